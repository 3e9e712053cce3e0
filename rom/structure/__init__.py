"""Structures: mass, damping and stiffness with contacts, M x'' + C x' + K x + W g(W^T x') = f.

structure.py    Eqs. (1), (2): Structure, checked once; two_mass, Eq. (26) and Table 1. Start here.
partition.py    Eq. (3): elastic and contact coordinates, x = E x_e + R x_c
held.py         contacts bonded or stuck: static solutions and modes from one factorisation
solvers/        sparse and dense: factorisation, lowest modes, definiteness
damping.py      Rayleigh: damping ratios, loss factor
labels.py       nodes and directions
files.py        matrices on disk: .npz, folders of Matrix Market files
external.py     matrices of other programs, assembled; readers/: their files
choice.py       which matrices of a file are the mass, the stiffness, the damping
matrices.py     dense or sparse matrices, checked
pairing/        contacts from meshes: W, areas, gaps and frames of surfaces that face each other
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
