"""Matrices of other programs.

external.py     which reader a file needs; its matrices under one numbering. Start here.
triplets.py     rows of text: node, direction, node, direction, value
abaqus.py       *MATRIX GENERATE; calculix.py: .sti, .mas, .dof
nastran.py      OP4 and DMIG; matlab.py: .mat; harwell_boeing.py: of Ansys and others
"""
