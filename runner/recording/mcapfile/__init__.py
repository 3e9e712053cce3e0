"""MCAP files written and read a chunk at a time, as arrays of messages.

writer.py     McapWriter: messages, chunks, indexes, summary. Start here.
scan.py       the records in their order; source.py, prefetch.py: where they come from
chunk.py      the messages of a chunk; layout.py: where bytes lie; statistics.py, summary.py
"""
