"""fit_contacts(): contact laws of a structure from measured backbones.

fit.py                  fit_contacts(): what the other files are called by. Start here.
groups.py               groups of contacts and their parameters
problem.py              the least-squares problem
data.py                 measured backbones as points with deviations
closed_form.py          frequency and damping of a mode by the describing functions of its contacts
describing_function.py  Jenkins elements under harmonic motion
table_check.py          frequency and damping by a friction table, for comparison
posterior.py            intervals, and combinations of parameters that the data determine
"""
