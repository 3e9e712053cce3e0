"""MCAP files written and read a chunk at a time, as arrays of messages."""
