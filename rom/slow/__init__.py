"""Slow time: the amplitude equations, their steady states, and the fast motion with them.

slow_flow.py      Eqs. (18), (19), which the core evaluates. Start here.
steady.py         Eqs. (22)-(25): steady states, resonance curves and surfaces
steady_points.py  steady states of many loads
steady_motion.py  displacement of DOFs in steady states
limit_cycle.py    limit cycles of self-excited modes
answer_error.py   errors of steady states due to the friction table
branches/         response curves, backbones, performance curves
direct/           steady states without a table
tone/             several modes on one tone: steady states, curves, runs
trajectory.py     amplitudes of a run
motion.py         contact and elastic motion of a run, Eqs. (12), (14)
nonresonant/      response of the other modes
rates/            damping and frequency of free vibration, and models made from them
transient.py      estimate of the error in transients
units.py          units of pictures and tables
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
