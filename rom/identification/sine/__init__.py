"""From sine tests of one mode to a law of the slow flow, with its uncertainty.

identification.py  identify_sine() and the identified law. Start here.
levels.py          one level: natural frequency, modal mass, damping, phase error
prediction.py      steady amplitudes of other tests, under their measured forces
responses.py       sine tests: responses and forces, checked
signals.py         time signals of sweeps and stepped sines
reading.py         files with sine tests
"""
