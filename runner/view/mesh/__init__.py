"""A mesh as it vibrates, its contacts coloured by state.

motion.py   MeshMotion, from arrays or a recording; show_mesh, write_mesh. Start here.
show.py     the drawing in Rerun
"""
