"""Identified laws of decays and sine tests, and their models.

identified.py      what both kinds of identification have. Start here.
joint.py           force of macro-slip and stiffness ratio of a joint
macro_slip.py      rates of a mode whose joint slips completely: Jenkins, Segalman
law_model.py       the law as a model that runs
sensor_units.py    sensor units as modal amplitudes
"""
