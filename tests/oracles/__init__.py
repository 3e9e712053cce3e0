"""Independent solutions of M x'' + C x' + K x + W f(W^T x) = F(t), and drawn structures.

Written from the equations, with nothing of slipmode. Each solution states its own error.
"""
