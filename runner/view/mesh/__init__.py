"""A mesh as it vibrates, with its contacts coloured by what they do.

mesh_motion.py   MeshMotion: nodes, cells, displacements, contact states. Start here.
skin.py          what is seen of a mesh: facets that one cell alone has
rerun_mesh.py    show_mesh: in Rerun; vtk.py: write_mesh, for ParaView
"""
