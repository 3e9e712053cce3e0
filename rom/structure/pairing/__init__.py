"""Contacts from meshes: nodes and the facets that they meet, with frames and areas.

contact_pairs.py   contact_pairs: from two surfaces of a mesh to contacts. Start here.
pairs.py           ContactPairs, the result: W, areas, gaps, frames; patches of equal area
surfaces.py        surfaces, nodes or facets: checks, shape functions, areas, normals
projection.py      points projected onto facets, and their motion with the facets
motion_patches.py  motion_patches: as few patches as given motions need, with their error
"""
