"""The figures of the source paper, drawn anew."""
