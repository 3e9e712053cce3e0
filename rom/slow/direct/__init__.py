"""Steady states without a table: one at a time, and where a table has no answer.

steady_state.py      what is called, and which way is taken
forced_balance.py    contacts, modes and forces in balance at all harmonics
receptance.py        what the modes do at the harmonics
integrated.py        by integration from rest, with two modes or where no balance is found
steady_harmonics.py  what is found, and what its errors are relative to
"""
