"""What a friction table is worth."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import Finding
from slipmode.rom.short_repr import percentage


@dataclass(frozen=True)
class Accuracy:
    """What the table was measured to be worth, in terms of `ErrorNorm`.

    Errors are relative to |S_j| + gamma_j Omega_j |a_j|, friction and structural damping in the
    amplitude equation, at amplitudes from 1e-3 of the range on. Of two modes they are relative to
    the largest |S_j| at that distance from rest, if that is more.

    Attributes
    ----------
    tolerance : float
        Tolerance of the table.
    interpolation : float
        Largest error between the nodes, from those found at points where most is expected; half
        the tolerance if that is more, for less is not looked for. Above the tolerance where
        friction jumps: contacts have two motions there, or none that repeats.
    resolution : float
        Change on doubling steps and lines of the contact problem. Of `rom.model_of_rates`: error
        of free vibration, because the slow flow is of first order in its rates.
    periodicity : float
        Largest distance from a periodic contact motion.
    neglected_response : float
        Relative change of S_j by the response of modes to higher-order harmonics that the table
        leaves out, the largest at a few amplitudes. Where the contact motion does not converge
        with that response: the largest motion due to one harmonic, relative to the motion without
        friction; infinity if none converges. 0 if the table has every harmonic that counts.
    neglected_modes : float
        Estimated relative change of S_j by the modes of the reduction that the table neglects: sum
        of their forces on the contacts, relative to those of the contact stiffness.
    detuning : float or None
        Error of forcing 5 % from the carriers, the largest of some trials.
        It grows with the square of that distance where the table has dS_j / dOmega_k, else in
        proportion. 0 in the paper's formulation, which has no other frequencies. None where
        friction was not to follow them, and nothing was tried.
    steps, lines : int
        Discretisation of the torus; 0 without contacts.
    solved : int
        Contact problems solved for the nodes and for measuring the interpolation; of
        `rom.model_of_rates` the amplitudes sampled for both.
    """

    tolerance: float
    interpolation: float
    resolution: float
    periodicity: float
    neglected_response: float
    neglected_modes: float
    detuning: float | None
    steps: int
    lines: int
    solved: int

    @property
    def total(self) -> float:
        """Stated error of S_j at the carriers; a neglected response is left out if unknown."""
        harmonics = self.neglected_response if isfinite(self.neglected_response) else 0.0
        return self.interpolation + self.resolution + harmonics + self.neglected_modes

    def findings(self) -> list[Finding]:
        """Return warnings of a table that misses its tolerance or neglects a response of modes."""
        found = []
        if self.interpolation > self.tolerance:
            reason = (
                f"its relative error is up to {percentage(self.interpolation)} (tolerance "
                f"{percentage(self.tolerance)}). At some amplitudes friction jumps, or the "
                "contact motion does not converge. Compare with slipmode validate"
            )
            found.append(Finding("friction table", "misses its tolerance", reason, "warning"))
        if (neglected := self.neglected_response) > ErrorBudget(self.tolerance).harmonics:
            reason = (
                "it is not known, because the contact motion at the largest amplitudes does not "
                "converge"
                if neglected == inf
                else f"it changes the contact motion by up to {percentage(neglected)}, but the "
                "contact motion does not converge with it"
            )
            reason += ". Compare with slipmode validate"
            choice = "above the fifth is neglected"
            found.append(Finding("response to harmonics", choice, reason, "warning"))
        return found
