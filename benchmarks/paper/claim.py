"""A claim of the paper, our values, and whether the two agree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.paper.study import Study

Verdict = Literal["reproduced", "not reproduced", "depends on unstated alpha, beta"]
Found = tuple[Mapping[str, Any], Any]  # our values, and whether the claim holds
Judge = Callable[[Study], Found]


@dataclass(frozen=True)
class Claim:
    """What the paper states and what we find."""

    name: str
    where: str  # section or figure of the paper
    stated: str
    note: str  # alpha and beta, and the bound that decides
    ours: Mapping[str, float]  # our values by their names
    verdict: Verdict


class Claims(list[Callable[[Study], Claim]]):
    """A list of claims; `add` decorates the function that judges one."""

    def add(self, where: str, stated: str, note: str) -> Callable[[Judge], Judge]:
        """Append the claim of a function; whether it holds is a bool for each alpha and beta."""

        def decorate(function: Judge) -> Judge:
            name = function.__name__.strip("_").replace("_", " ")

            def judged(study: Study) -> Claim:
                ours, holds = function(study)
                return Claim(name, where, stated, note, ours, judge(holds))

            self.append(judged)
            return function

        return decorate


def judge(holds: ArrayLike) -> Verdict:
    """Return the verdict on a claim that was tried once or with several values."""
    tried = np.asarray(holds, dtype=bool)
    if tried.all():
        return "reproduced"
    return "depends on unstated alpha, beta" if tried.any() else "not reproduced"


def as_lines(claims: Iterable[Claim]) -> Iterable[str]:
    """Yield three lines for each claim: what is stated, our values, the note."""
    for claim in claims:
        values = ", ".join(f"{name} {value:.4g}" for name, value in claim.ours.items())
        yield f"{claim.verdict:32}{claim.where:14}{claim.stated}"
        yield f"{'':46}{values}"
        yield f"{'':46}({claim.note})"
