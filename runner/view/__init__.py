"""Recordings in Rerun.

replay.py              a recording, shown. Start here; rerun_sink.py: to a file or a viewer
views.py               plots, texts and their layout; labels.py: titles, legends, units, words
phase_portraits.py     paths and loops; samples.py: what they keep; drawing.py: what they share
spatial/               motion over two phases, a surface; every sector of a disk
charts.py              one quantity against another without time: of studies and curves
mesh/                  a mesh as it vibrates, its contacts coloured by state
viewer.py              viewers with a window and without; pictures
foxglove.py            a layout for Foxglove
"""
