"""The source paper's figures 3 to 13 and its quantitative claims: python -m benchmarks.paper.

study.py     what figures and claims are made from; case.py: the example, Table 1
slices.py    resonance curves, and how they depend on alpha and beta
claim.py     what a claim is; *_claims.py: the claims
*_figures.py the figures, in the style of style.py
"""
