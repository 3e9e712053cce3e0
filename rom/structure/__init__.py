"""Structures: mass, damping and stiffness with contacts, M x'' + C x' + K x + W g(W^T x') = f.

structure.py           Eqs. (1), (2): Structure, checked once; two_mass, Eq. (26). Start here.
partition.py           Eq. (3): elastic and contact coordinates, x = E x_e + R x_c
held.py                contacts bonded or stuck: static solutions and modes, by one factorisation
factorisation.py       by LAPACK, PARDISO or SuperLU; nested_dissection.py: in which order
lowest_modes.py        block Lanczos
mobility.py            W^T M^-1 W
files.py               matrices on disk: .npz, Matrix Market
matrices.py            dense or sparse, as they are given; definiteness.py; memory.py
"""
