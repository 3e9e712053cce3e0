"""Branches of steady states: response curves with stability, backbones.

continuation.py      solution curves of F(y, p) = 0, folds and Hopf points on them
branches.py          all branches of a curve with their error, from the table or without it
curve_error.py       errors of curves, and folds and Hopf points that are smaller than them
response_curve.py    steady states of the slow flow against frequency, force or friction limit
oscillation.py       slow limit cycles beyond Hopf points
forced.py            the slow flow with a varied parameter, and all its steady states
backbone.py          damped nonlinear modes: frequency and damping, resonance peaks
performance.py       damper design: resonance peak against friction limit or preload
curve_result.py      columns, displacements and error bands of all curves and surfaces
solve_points.py      Newton's method at many points, and frequencies at given amplitudes
"""
