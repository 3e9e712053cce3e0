"""Records of a test: reading, what is wrong with them, and their usable parts.

measurement.py  records of a test. Start here.
reading.py      files with records
fields.py       named arrays of a file, their units, times and sampling rate
text_table.py   text files in any dialect
files.py        arrays in files, and sampling rates
universal.py    universal files
defects.py      what is wrong with the samples of a record
preparation.py  the usable part of each record, and why others are excluded
"""
