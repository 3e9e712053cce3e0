"""Recordings in Rerun.

replay.py              a recording, shown. Start here; live.py: while it is being made.
rerun_sink.py          samples to Rerun, by the layout of views.py; rerun_file.py: to a file
phase_portraits.py, torus_view.py, tail.py, envelope.py   what is drawn other than curves
charts/                one quantity against another without time: of studies and curves
mesh/                  a mesh as it vibrates, its contacts coloured by state
viewer.py, screenshot.py   viewers with a window and without; pictures
"""
