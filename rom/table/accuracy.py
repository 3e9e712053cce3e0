"""What a friction table is worth."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

from slipmode.rom.contact.detuning import MOST_DETUNING
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import Finding
from slipmode.rom.short_repr import percentage


@dataclass(frozen=True)
class Accuracy:
    """Hold the measured errors of a friction table.

    Errors are relative to |S_j| + gamma_j Omega_j |a_j|, friction and structural damping in the
    amplitude equation, at amplitudes above 1e-3 of the range. With two modes this scale is at
    least the largest |S_j| times rho = max_k |a_k| / range_k.

    Attributes
    ----------
    tolerance : float
        Requested relative error of the table [-].
    interpolation : float
        Largest interpolation error [-], measured between the nodes where the error indicator is
        largest, and at least half the tolerance. It exceeds the tolerance where friction jumps:
        the contact problem has two periodic solutions there, or none.
    resolution : float
        Relative change on doubling steps and lines of the contact problem [-]. For
        `rom.model_of_rates`: relative error of free vibration, because the slow flow is of first
        order in its rates.
    periodicity : float
        Largest relative deviation from a periodic contact motion [-].
    neglected_response : float
        Largest relative change of S_j by the neglected harmonic response of modes to higher-order
        harmonics [-], measured at a few amplitudes. If the contact motion does not converge with
        this response: largest motion due to one harmonic, relative to the motion without friction.
        Infinite if none converges, and 0 if the table has every relevant harmonic.
    neglected_modes : float
        Estimated relative change of S_j by the nonresonant modes that the table neglects [-].
    detuning : float or None
        Largest relative error due to forcing at `distance` from the carriers [-], of some trials.
        It grows with the square of the distance if the table has dS_j / dOmega_k, otherwise in
        proportion.
        0 in the formulation "paper". None if `detuning=False` was given.
    steps, lines : int
        Time steps per period and phase lines of the contact problem; 0 without contacts.
    solved : int
        Number of contact problems solved. For `rom.model_of_rates`: number of sampled amplitudes.
    distance : float
        Relative distance from the carriers at which `detuning` is measured [-].
    """

    tolerance: float
    interpolation: float
    resolution: float = 0.0
    periodicity: float = 0.0
    neglected_response: float = 0.0
    neglected_modes: float = 0.0
    detuning: float | None = 0.0
    steps: int = 0
    lines: int = 0
    solved: int = 0
    distance: float = MOST_DETUNING

    @property
    def total(self) -> float:
        """Stated relative error of S_j at the carriers [-], without a response of unknown size."""
        return self.interpolation + self.resolution + self.neglected

    @property
    def neglected(self) -> float:
        """Relative error of S_j by neglected modes and harmonics [-], as far as it is known."""
        harmonics = self.neglected_response if isfinite(self.neglected_response) else 0.0
        return harmonics + self.neglected_modes

    def findings(self) -> list[Finding]:
        """Return warnings if the tolerance is not met or a harmonic response is neglected.

        Returns
        -------
        list of Finding
            Empty if the table meets its tolerance.
        """
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
