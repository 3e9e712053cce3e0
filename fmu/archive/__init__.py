"""The .fmu file: its resources, binaries and sources, written and read."""
