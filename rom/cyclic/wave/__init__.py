"""Travelling waves of one nodal diameter, or of two at two frequencies, from one sector.

travelling_wave.py  TravellingWave: steady states and limit cycles. Start here.
wave_state.py       waves in a steady state or limit cycle, and their stability
wave_balance.py     the forces on a wave
wave_problem.py     the contact problem of one or two waves
wave_resonances.py  harmonics near modes of other nodal diameters
stability/          which nodal diameters flutter, waves that break into pairs
two_waves.py        tabulate_waves: two waves at two frequencies
wave_table.py       models of one or two waves, also kept on disk
wave_motion.py      motion of one sector along a slow trajectory
"""
