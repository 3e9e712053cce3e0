"""Recordings: MCAP files, written while a scene runs, and read back as arrays.

channels.py    what is recorded: fields and units of each channel. Start here.
record.py      Recorder and its sinks; provenance.py, overview.py: what else goes into a file
load.py        read and load; selection.py: a part of it; export.py: .npz, .csv, .parquet
mcapfile/      the format; check/: info, doctor, recover; external/: files of other programs
"""
