"""The amplitude grid of a friction table: dense where the slip threshold bends the surface.

refine.py            refine: cells are halved until check points agree. Start here
grid.py              grid lines, and which cells are to be halved
blocks.py            what has samples at its corners alone, across grid lines
contact_samples.py   samples of the contact problem, on several threads
sampling.py          what samples hold, and how far a table is off them
"""
