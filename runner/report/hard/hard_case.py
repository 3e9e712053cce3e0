"""What a hard case is, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from slipmode import rom
from slipmode.runner.report.cases.cases import Case

# Bounds that several cases share
SIGNAL = 5e-3  # RMS of displacements over a run from rest, as the report states it
FLOW = 1e-6  # of the slow flow: the internal tolerance of a component


@dataclass(frozen=True, eq=False)
class HardCase:
    """A case and its bound.

    Attributes
    ----------
    name : str
    risk : str
        What could go wrong.
    quantity : str
        What is measured.
    bound : float
        Largest value that is allowed.
    measure : callable
        Returns the value; raises SlipmodeError where the case is refused.
    refusal : str
        Words of the message where the case must be refused; empty where it must be met.
    motion : Case, optional
        The same case for other integrators; None where there is no motion to compare.
    slow : bool
        Takes more than a second or two.
    """

    name: str
    risk: str
    quantity: str
    bound: float
    measure: Callable[[], float]
    refusal: str = ""
    motion: Case | None = None
    slow: bool = False

    def judge(self) -> Outcome:
        """Measure it."""
        try:
            return Outcome(self, self.measure())
        except rom.SlipmodeError as error:
            return Outcome(self, float("nan"), " ".join(str(error).split()))


@dataclass(frozen=True, eq=False)
class Outcome:
    """A case as measured.

    Attributes
    ----------
    case : HardCase
    measured : float
        NaN where the case is refused.
    reason : str
        Of the refusal, in one line; empty where there is none.
    """

    case: HardCase
    measured: float
    reason: str = ""

    @property
    def as_it_must(self) -> bool:
        """Whether the bound is met, or the case refused where it must be."""
        if self.case.refusal:
            return self.case.refusal in self.reason
        return self.measured <= self.case.bound

    @property
    def verdict(self) -> str:
        """In one word."""
        if not self.as_it_must:
            return "MISSED"
        return "refused" if self.reason else "met"
