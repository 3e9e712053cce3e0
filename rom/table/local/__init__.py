"""Friction by contact: a table for each contact instead of one over amplitudes of modes.

tone_model.py      several modes on one tone, whose contacts have tables. Start here.
local_contacts.py  the tables
dual_contacts.py   contacts whose displacement is given, as the core reads them
"""
