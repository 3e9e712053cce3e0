"""Independent solutions of M x'' + C x' + K x + W f(W^T x) = F(t).

Written from the equations, with nothing of slipmode. Each solution states its own error.

system.py            matrices, contact laws, forcing tones
time_integration.py  exponential integrator (march.c) and steady harmonics
harmonic_balance.py  periodic motion and damped nonlinear modes of sliders
closed_forms.py      one contact under harmonic motion
families.py          drawn structures
"""
