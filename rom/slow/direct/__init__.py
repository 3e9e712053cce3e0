"""Steady states without a table: for one or a few forcings, and outside the range of tables.

steady_state.py      steady_state, and the choice of the method. Start here.
forced_balance.py    contacts, modes and forces in balance at all harmonics
integrated.py        integration in time from rest
steady_harmonics.py  harmonics, their relative errors, and the response of the modes to them
contact_friction.py  friction from the contact problem at the forcing frequencies
resonant_response.py modes in resonance with harmonics, as unknowns
contact_curve.py     steady states with it as a curve
corrected_points.py  steady states whose friction a table misses
"""
