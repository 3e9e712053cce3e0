"""Modes that respond to harmonics of the contacts: internal resonances, modes to retain together.

internal_resonance.py  how far a mode moves the contacts at a harmonic. Start here.
mode_proposals.py      which modes must be retained together, and why
"""
