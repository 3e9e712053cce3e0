"""Recordings: MCAP files, written while a scene runs, and read back as arrays.

channels.py    what is recorded: fields and units of each channel. Start here.
record.py      Recorder and its sinks; overview.py: a channel that viewers plot without a layout
load.py        read, load, Selection; external.py: files of other programs; export.py: to others
check.py       info and doctor; recover.py: damaged files
inventory.py   the contents of a file, and what is missing from it, for all of these
mcap_reader.py   the walk over the records of a file, whole or damaged; mcap_writer.py
mcap_layout.py   messages as arrays; mcap_summary.py: the summary of a file
"""
