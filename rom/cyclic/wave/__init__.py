"""Travelling waves of one nodal diameter, or of two at two frequencies, from one sector.

travelling_wave.py  TravellingWave: steady states and limit cycles. Start here.
wave_state.py       a wave in a steady state or limit cycle, and its stability
wave_problem.py     the contact problem of one or two waves
wave_balance.py     amplitudes at which a wave is in balance
wave_cycles.py      limit cycles of a self-excited wave
wave_resonances.py  harmonics near modes of other nodal diameters
pair_stability.py   whether waves break into pairs of others
flutter_growth.py   which nodal diameters flutter
two_waves.py        tabulate_waves: two waves at two frequencies
wave_table.py       friction table and model of one or two waves
wave_dofs.py        displacement of DOFs by the other modes, for models
wave_motion.py      motion of one sector along a slow trajectory
"""
