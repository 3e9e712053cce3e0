"""Solutions with the matrices of a structure, small or large.

factorisation.py        by LAPACK, PARDISO or SuperLU. Start here.
elimination.py          of the interior alone: stiffness of the boundary
nested_dissection.py    the order of elimination for SuperLU
lowest_modes.py         block Lanczos
mass.py                 definiteness of mass and damping; W^T M^-1 W
"""
