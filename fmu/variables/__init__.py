"""The variables of an FMU: one list, from which everything else about them is derived."""
