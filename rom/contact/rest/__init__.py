"""Contacts at rest under a static force.

static_preload.py        the equilibrium, and the law for vibration about it
admissible_tractions.py  what else friction can hold there, from the least to the largest limits
"""
