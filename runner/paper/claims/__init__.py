"""The quantitative claims of the source paper, judged."""
