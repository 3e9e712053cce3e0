"""The contact problem: the periodic motion of the contacts under the laws of rom/laws.

problem.py    Eqs. (13), (14): ContactProblem, its discretisation and its solution. Start here.
terms.py      Eq. (20): friction terms S_j = Q_j |a_j| of the solution, dissipated power
torus         the march along the torus of the phases, as the core reads it
resolution.py         steps, phase lines and march tolerance that a tolerance of S needs
error_norm.py         what errors of S_j are relative to
higher_order_harmonics.py  harmonics beyond the fifth to which modes respond
harmonics.py          Eq. (14) over the amplitude plane, for sums of fast motion
slip_onset.py         where in the amplitude plane contacts begin to slip or open
static_preload.py     contacts under a static force
rate_correction.py    friction while amplitudes grow: dS_j / d(d|a_k|/dt)
detuning.py           friction where the forcing is off the carriers: dS_j / dOmega_k
time_budget.py        limits of time and of counted work
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
