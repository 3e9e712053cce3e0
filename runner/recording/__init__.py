"""Recordings: MCAP files, written while a scene runs, and read back as arrays.

channels.py    what is recorded: fields and units of each channel. Start here.
record.py      Recorder and its sinks; overview.py: a channel that viewers plot without a layout
load.py        read, load, Selection; external.py: files of other programs; export.py: to others
check.py       info and doctor; recover.py: damaged files
inventory.py   what a file holds and what is missing from it, for all who read it
mcap_file/     the file itself: writer, reader, and one walk over its records
"""
