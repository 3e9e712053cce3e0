"""Recordings: MCAP files, written while a scene runs, and read back as arrays.

channels.py    what is recorded: fields and units of each channel. Start here.
record.py      Recorder and its sinks; overview.py: a channel that viewers plot without a layout
load.py        read, load, Selection; external.py: files of other programs; export.py: to others
check.py       info and doctor; recover.py: damaged files
mcap_writer.py arrays of messages become chunks of MCAP files; contents/: how they are read
"""
