"""Travelling waves of one nodal diameter, or of two at two frequencies, from one sector.

travelling_wave.py  TravellingWave: steady states and limit cycles. Start here.
wave_state.py       a wave in a steady state or limit cycle, and its stability
wave_problem.py     the contact problem of one or two waves
wave_balance.py     amplitudes at which a wave is in balance
wave_resonances.py  harmonics near modes of other nodal diameters
stability/          which nodal diameters flutter, limit cycles, waves that break into pairs
two_waves.py        tabulate_waves: two waves at two frequencies
wave_table.py       friction table and model of one or two waves
wave_dofs.py        displacement of DOFs by the other modes, for models
wave_motion.py      motion of one sector along a slow trajectory
"""
