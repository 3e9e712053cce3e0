"""Contacts from meshes: which nodes meet which facets, in what frame, on what area.

contact_pairs.py   contact_pairs: from two surfaces of a mesh to contacts. Start here.
pairs.py           ContactPairs, the result: W, areas, gaps, frames; gathered into patches
surfaces.py        surfaces as they are given, nodes or facets, checked
facets.py          triangles and quadrilaterals: shape functions, areas, normals, which side
projection.py      points projected into facets, and how these move them
frames.py          a normal and two tangents for each contact
patches.py         contacts divided into patches of about the same area
motion_patches.py  motion_patches: into as few as given motions need, with the error
"""
