"""Hard cases, a file for each kind of strain.

Changes of the forcing, contacts, levels, ratios of frequencies, sharpness of friction, stepping,
units; and the growth of cost with the number of contacts.
"""
