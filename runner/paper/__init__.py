"""The paper's figures 3 to 13 and its quantitative claims, computed again and judged."""

from slipmode.runner.paper.claims.claim import Claim, Verdict
from slipmode.runner.paper.command import Findings, paper

__all__ = ["Claim", "Findings", "Verdict", "paper"]
