"""Small structures that full order runs on in place of large ones.

component_modes.py      Craig-Bampton or stuck modes, as many as a tolerance needs
projection.py           a structure on such shapes, and on those of its reduced model
reduced_structure.py    the structure that a reduced model has, without the matrices
orthonormal.py          modes and other shapes made a basis that is orthonormal in the mass
"""
