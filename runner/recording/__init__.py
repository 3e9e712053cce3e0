"""Recordings: channels, MCAP files written and read, their export."""
