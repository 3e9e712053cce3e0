"""Readers of the matrix files of other programs.

A reader returns one matrix (`Named`), or a dict of several by the names that the file gives them.
Readers import their packages when they are called, because these take a while to import.

by_suffix.py         the reader of each suffix. Start here.
named.py             Named, a matrix and labels of its rows; symmetric matrices of one triangle
text.py              text in any encoding, numbers as Fortran writes them
abaqus.py            .mtx: *MATRIX GENERATE and substructures of Abaqus, Matrix Market; CalculiX
harwell_boeing.py    Ansys HBMAT, LS-DYNA
op4.py, dmig.py      Nastran
workspace.py         MATLAB .mat of all versions, NumPy .npz
"""
