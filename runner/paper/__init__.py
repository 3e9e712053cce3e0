"""The paper's figures 3 to 13 and its quantitative claims, computed again and judged.

study.py     what figures and claims are made from; case.py: the example, Table 1. Start here.
figures/     each figure; claims/: each claim, with what it says and what was found
upwind.py    the paper's scheme for the contact problem, Eq. (31)
"""

from slipmode.runner.paper.claims.claim import Claim, Verdict
from slipmode.runner.paper.command import Findings, paper

__all__ = ["Claim", "Findings", "Verdict", "paper"]
