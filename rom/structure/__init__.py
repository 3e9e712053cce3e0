"""Structures: mass, damping and stiffness with contacts, M x'' + C x' + K x + W g(W^T x') = f.

structure.py   Eqs. (1), (2): Structure, checked once; two_mass, Eq. (26) and Table 1. Start here.
partition.py   Eq. (3): elastic and contact coordinates, x = E x_e + R x_c
files.py       matrices on disk: .npz, Matrix Market
matrices.py    dense or sparse; symmetry and definiteness
pairing/       contacts from meshes: W, areas, gaps and frames of surfaces that face each other
"""
