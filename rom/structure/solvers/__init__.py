"""What is solved with the matrices of a structure, however large.

factorisation.py        by LAPACK, PARDISO or SuperLU. Start here.
nested_dissection.py    the order for SuperLU; memory.py: what there is of it
lowest_modes.py         block Lanczos
definiteness.py         of mass and damping matrices
mobility.py             W^T M^-1 W
"""
