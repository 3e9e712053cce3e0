"""A claim of the paper, our value, and whether the two agree."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

Verdict = Literal["reproduced", "not reproduced", "depends on unstated alpha, beta"]


@dataclass(frozen=True)
class Claim:
    """What the paper states and what we find.

    Attributes
    ----------
    name : str
        Short, unique.
    where : str
        Section or figure of the paper.
    stated : str
        In words.
    ours : mapping of str to float
        Our values by what they are.
    verdict : Verdict
    note : str
        The values of alpha and beta, and the bound that decides.
    """

    name: str
    where: str
    stated: str
    ours: Mapping[str, float]
    verdict: Verdict
    note: str


def judge(holds: bool) -> Verdict:
    """The verdict on a claim that hangs on nothing unstated."""
    return "reproduced" if holds else "not reproduced"


def judge_over(holds: ArrayLike) -> Verdict:
    """The verdict on a claim that was tried with several values of alpha and beta."""
    tried = np.asarray(holds, dtype=bool)
    if tried.any() and not tried.all():
        return "depends on unstated alpha, beta"
    return judge(bool(tried.all()))


def as_lines(claims: Iterable[Claim]) -> list[str]:
    """A table for the terminal: one line per claim, its values and its note below."""
    lines = []
    for claim in claims:
        lines.append(f"{claim.verdict:32}{claim.where:14}{claim.stated}")
        lines += [f"{'':46}{values(claim)}", f"{'':46}({claim.note})"]
    return lines


def as_markdown(claims: Iterable[Claim]) -> str:
    """The same as a Markdown table."""
    rows = ["| where | verdict | stated | ours | note |", "|---|---|---|---|---|"]
    for c in claims:
        cells = (c.where, c.verdict, c.stated, values(c), c.note)
        rows.append(f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |")
    return "\n".join(rows)


def values(claim: Claim) -> str:
    """Our values, four digits each."""
    return ", ".join(f"{name} {value:.4g}" for name, value in claim.ours.items())
