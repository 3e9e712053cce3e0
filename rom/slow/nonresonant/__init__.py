"""What the slow flow does not integrate: modes that respond to harmonics of the contacts, and to
forces off their resonance.

Start with response.py, at one amplitude; response_surface.py has it at the nodes of a table.
"""
