"""Steady states without a table: for one or a few forcings, and where a table has no answer.

steady_state.py      steady_state, and the choice of the method. Start here.
forced_balance.py    contacts, modes and forces in balance at all harmonics
receptance.py        response of the modes to the harmonics
integrated.py        integration in time from rest
steady_harmonics.py  the result, and relative errors of its amplitudes
"""
