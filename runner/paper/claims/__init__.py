"""The quantitative claims of the source paper, judged.

claim.py says what a claim and a verdict are, claims.py lists them all; the others hold those on
friction functions, on resonance curves, and on motion.
"""
