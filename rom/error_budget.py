"""Shares of a model's tolerance for each source of error."""

from __future__ import annotations

from dataclasses import dataclass

#: Default relative error per internal step of the slow flow. Errors of the steps add up over about
#: ten relaxation times, and stay far below the errors of tables.
SLOW_FLOW = 1e-6

LARGEST_TOLERANCE = 0.1  # of a table


def within_reach(tolerance: float) -> str:
    """Return the advice of a refusal that found this tolerance to be possible."""
    if tolerance <= LARGEST_TOLERANCE:
        return f"a tolerance of {tolerance:g} is within reach"
    return "no allowed tolerance is within reach; use time integration (rom.full)"


@dataclass(frozen=True)
class ErrorBudget:
    """Shares of the tolerance of S_j, each relative to `ErrorNorm`.

    A table measures its interpolation error against exact samples; the errors of the samples are
    small against it.

    Attributes
    ----------
    tolerance : float
        Tolerance of the finished table.
    """

    tolerance: float

    @property
    def interpolation(self) -> float:
        """Error of the surface between its nodes."""
        return self.tolerance

    @property
    def resolution(self) -> float:
        """Error of samples due to the steps and phase lines of the contact problem."""
        return 0.5 * self.tolerance

    @property
    def steps(self) -> float:
        """Error of samples due to the steps, or to phase lines that drift."""
        return 0.5 * self.resolution

    @property
    def closed_lines(self) -> float:
        """Error of samples due to phase lines that close; steps may take the rest."""
        return 0.6 * self.resolution

    @property
    def harmonics(self) -> float:
        """Change of S_j by harmonics beyond the fifth to which no mode responds in the model."""
        # To 1e-3 a few amplitudes do not show how much: without them an amplitude was 2e-3 off
        # (test_a_response_curve_moves_dofs_as_the_steady_state_does).
        return 0.5 * self.tolerance if self.tolerance >= 5e-3 else 0.0

    @property
    def response(self) -> float:
        """Motion of the contacts due to one such harmonic, if the model has those with more."""
        return 0.1 * self.tolerance

    @property
    def modes(self) -> float:
        """Error of S_j due to modes that a table neglects."""
        return 0.1 * self.tolerance

    @property
    def march(self) -> float:
        """Error of samples due to contact motion that is not yet periodic."""
        return 0.1 * self.tolerance

    @property
    def trial_march(self) -> float:
        """`march` while resolutions are compared."""
        return 0.1 * self.resolution
