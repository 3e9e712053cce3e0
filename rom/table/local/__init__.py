"""Friction by contact: a table for each contact instead of one over amplitudes of modes.

tone_model.py      several modes on one or two tones. Start here.
local_contacts.py  the tables of contacts under one or two tones
dual_contacts.py   contacts whose displacement is given, as the core reads them
"""
