"""Geometric nonlinearity of the retained modes.

stiffness.py     quadratic and cubic coefficients, and their stiffness in slow time
static_cases.py  coefficients from static load cases of a finite-element program
"""
