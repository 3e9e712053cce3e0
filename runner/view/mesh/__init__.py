"""A mesh as it vibrates, its contacts coloured by state.

motion.py   MeshMotion, from arrays or a recording; write_mesh, for ParaView. Start here.
show.py     show_mesh, in Rerun
"""
