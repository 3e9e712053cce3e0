"""From steady sine tests of one mode to a law of the slow flow, with its uncertainty.

identification.py  identify_sine(), the identified law and its predictions. Start here.
levels.py          one level: natural frequency, modal mass, damping, phase error
reading.py         sine tests, and files with them
"""
