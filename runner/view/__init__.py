"""Recordings in Rerun.

replay.py              a recording, shown. Start here; rerun_sink.py: to a file or a viewer
plots.py               what is plotted from which channel, for all programs; labels.py: numbers
views.py               plots over time, texts and the layout of all views
phase_portraits.py     paths and loops; samples.py: what they keep; drawing.py: what they share
spatial/               motion over two phases, a surface; every sector of a disk
charts.py              one quantity against another without time: of studies and curves
mesh/                  a mesh as it vibrates, its contacts coloured by state
viewer.py              viewers with a window and without; pictures
foxglove.py            a layout for Foxglove
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
