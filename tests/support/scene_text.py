"""Parts that the scenes of several tests have in common."""

TANH_ON_BOTH_MODES = """\
[friction]
law = "tanh"
limit = 2.0
alpha = 0.02
[modes]
A = 0
B = 1
"""
