"""The amplitude grid of a friction table: dense where the slip threshold bends the surface.

refine.py        refine: cells are halved until check points agree. Start here.
grid.py          grid lines, which cells are to be halved, and samples at the nodes
check_points.py  where the error of a table is measured, and what that says of the largest
sampling.py      what samples of the contact problem hold, and how far a table is off them
"""
