"""Travelling waves of one nodal diameter, or of two at two frequencies, from one sector.

travelling_wave.py  TravellingWave: steady states; tabulate_waves. Start here.
wave_problem.py     the contact problem of one or two waves
wave_table.py       their friction table and model; cache.py: models kept on disk
wave_motion.py      motion of one sector along a slow trajectory
"""
