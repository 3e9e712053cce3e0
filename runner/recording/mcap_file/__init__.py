"""MCAP files as arrays of messages, whole or damaged.

writer.py    arrays of messages become chunks; reader.py: chunks become arrays
walk.py      the walk over the records of a file, and its continuation after damage
records.py   records from bytes and to bytes
"""
