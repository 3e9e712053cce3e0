"""The contact problem: the periodic motion that the laws of rom/laws let the contacts have.

friction_terms.py    Eq. (20): what contacts do to the modes, S_j = Q_j |a_j|. Start here.
torus                Eqs. (13), (14): harmonics P_nm of their motion
resolution.py        steps and phase lines of the march that finds it, from the tolerance
settled.py           whether that march has come to a periodic motion
further_harmonics.py  high harmonics that modes respond to, found by a trial
harmonics.py         Eq. (14) over the amplitude plane, for the sum of fast motion
slip_onset.py        where in the amplitude plane contacts begin to slip or open
static_preload.py    what a static force makes of the contacts
rate_correction.py   friction while amplitudes grow: dS_j / d(d|a_k|/dt)
detuning.py          friction where the forcing is off the carriers: dS_j / dOmega_k
"""
