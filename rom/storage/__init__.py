"""Files: paths, text of any encoding, arrays within limits of memory, and a digest of the code."""
