"""Steady states without a table: one at a time, and where a table has no answer.

steady_state.py      what is called: harmonics, phase lines, time steps until the tolerance is met
forced_balance.py    contacts, modes and forces in balance at all harmonics
receptance.py        what the modes do at the harmonics
integrated.py        by integration from rest, where no balance is found
"""
