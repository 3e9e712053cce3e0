"""From measured loops of force against displacement to a contact law.

fit.py       fit_loops(): the smallest model that describes the loops. Start here.
reading.py   read_loops(): files
loop.py      a measured loop, its strokes and cycles
model.py     Jenkins elements, a backlash and a spring: forces along strokes
problem.py   least squares of one model, and intervals from the cycles
result.py    what is found: laws, parameters, errors, a picture
"""
