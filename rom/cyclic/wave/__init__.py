"""Travelling waves of one nodal diameter, or of two at two frequencies, from one sector.

travelling_wave.py  TravellingWave: steady states and limit cycles. Start here.
wave_state.py       waves in a steady state or limit cycle, and their stability
wave_problem.py     the contact problem of one or two waves, and its resonances
stability/          which nodal diameters flutter, waves that break into pairs
wave_table.py       models of one or two waves, also kept on disk
wave_motion.py      motion of one sector along a slow trajectory
"""
