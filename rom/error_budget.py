"""Which share of a model's tolerance each source of error may take."""

from __future__ import annotations

from dataclasses import dataclass

#: Relative error per internal step of the slow flow, where a user does not say: errors of the
#: steps add up over some ten relaxation times, and stay far below those of any table.
SLOW_FLOW = 1e-6

LARGEST_TOLERANCE = 0.1  # of a table


def within_reach(tolerance: float) -> str:
    """What a refusal says of a tolerance that was reached."""
    if tolerance <= LARGEST_TOLERANCE:
        return f"a tolerance of {tolerance:g} is within reach"
    return "no tolerance that is allowed is within reach: use time integration (rom.full)"


@dataclass(frozen=True)
class ErrorBudget:
    """Shares of the tolerance of S_j, each relative to `ErrorNorm`.

    The tolerance is that of what is measured in the end, the interpolation between exact samples;
    samples are kept exact enough not to disturb that measurement.

    Attributes
    ----------
    tolerance : float
        Of the finished table.
    """

    tolerance: float

    @property
    def interpolation(self) -> float:
        """Of the surface between its nodes."""
        return self.tolerance

    @property
    def resolution(self) -> float:
        """Of samples, by the steps and phase lines of the contact problem."""
        return 0.5 * self.tolerance

    @property
    def steps(self) -> float:
        """Of samples, by the steps, or by phase lines that drift: nodes differ by all of that."""
        return 0.5 * self.resolution

    @property
    def closed_lines(self) -> float:
        """Of samples, by phase lines that close; steps may take what these leave."""
        return 0.6 * self.resolution

    @property
    def response(self) -> float:
        """Of the contacts' motion, by a harmonic that modes are not taken to respond to."""
        return 0.1 * self.tolerance

    @property
    def modes(self) -> float:
        """Of S_j, by modes that a table neglects."""
        return 0.1 * self.tolerance

    @property
    def march(self) -> float:
        """Of samples, by contact motion that is not yet periodic."""
        return 0.1 * self.tolerance

    @property
    def trial_march(self) -> float:
        """The same while resolutions are compared."""
        return 0.1 * self.resolution
