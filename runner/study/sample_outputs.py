"""The outputs that a study requests of each sample, and the arrays that hold them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import frozen

MODAL = "kg^1/2 m"


@dataclass(frozen=True)
class Curve:
    """Steady states over the frequency of one mode's force [rad/s], the other force constant."""

    mode: str
    first: float
    last: float
    points: int

    @property
    def frequency(self) -> Floats:
        """(points,) [rad/s]."""
        return np.linspace(self.first, self.last, self.points)


@dataclass(frozen=True)
class Result:
    """An array of results: dimensions after "sample" with their sizes, unit and meaning."""

    name: str
    sizes: dict[str, int]
    unit: str
    meaning: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the entry of one sample."""
        return tuple(self.sizes.values())


@dataclass(frozen=True)
class Outputs:
    """The outputs of a study."""

    steady: bool = False  # Steady amplitudes under the forces at the end of the scene
    # Modes of which the highest resonance peak is computed, under the force on this mode alone
    resonance: tuple[str, ...] = ()
    curve: Curve | None = None
    peak: bool = False  # Largest amplitudes of the run
    times: tuple[float, ...] = ()  # Times of the run at which amplitudes are stored [s]
    recording: bool = False  # A recording of each run
    # DOFs whose amplitudes are stored in addition to the modal amplitudes
    dofs: tuple[int, ...] = ()
    mistuned: bool = False  # Whether the disk is mistuned: its curve has the largest blade

    KINDS: ClassVar = ("steady", "resonance", "curve", "peak", "times", "recording")

    @property
    def runs(self) -> bool:
        """Whether samples run through slow time on the model that they share."""
        return self.peak or bool(self.times)

    def results(self, modes: tuple[str, ...]) -> list[Result]:
        """Return the arrays, for the modes of the scene."""
        found: list[Result] = []

        def add(name: str, meaning: str, unit: str = MODAL, **more: int) -> None:
            sizes = {"mode": len(modes)} | more
            found.append(Result(name, sizes, unit, meaning))
            if self.dofs and unit == MODAL:
                sizes = sizes | {"dof": len(self.dofs)}
                words = f"{meaning}, as displacement amplitude of DOFs at the mode's carrier"
                found.append(Result(f"{name}_displacement", sizes, "m", words))

        if self.mistuned and self.curve:
            points = self.curve.points
            add("curve", "largest steady amplitude of all blades", "m", frequency=points)
            add("resonance", "largest of the curve", "m")
            add("resonance_frequency", "its frequency", "rad/s")
            add("amplification", "resonance relative to that of the tuned disk", "-")
            return found
        if self.steady:
            add("steady", "steady amplitude |a|")
            add("steady_phase", "its phase", "rad")
        if self.resonance:
            add("resonance", "resonance peak |a|")
            add("resonance_frequency", "its frequency", "rad/s")
        if self.curve:
            add("curve", "steady amplitude |a|", frequency=self.curve.points)
        if self.peak:
            add("peak", "largest |a| of the run")
        if self.times:
            add("at", "|a| at times of the run", time=len(self.times))
        if self.runs:
            add("run_error", "largest estimated transient error of |a| in the run")
        return found

    @property
    def single_numbers(self) -> tuple[str, ...]:
        """Results that are one number per sample, by the names that [choose] has for them."""
        if self.mistuned:
            return ("resonance_A", "amplification_A")
        kinds = [kind for kind in ("steady", "peak") if getattr(self, kind)]
        found = [f"{kind}_{mode}" for kind in kinds for mode in ("A", "B")]
        return (*found, *(f"resonance_{mode}" for mode in self.resonance))


@frozen
class Batch:
    """Results of some samples."""

    values: dict[str, Floats]  # (samples, ...) by the names of `Outputs.results`
    reason: list[str]  # Why a sample has no results; empty if it has
    outside: Flags  # (samples,): Whether a larger friction table is needed

    @classmethod
    def empty(cls, outputs: Outputs, modes: tuple[str, ...], count: int) -> Batch:
        """Return a batch without results: NaN."""
        found = outputs.results(modes)
        values = {each.name: np.full((count, *each.shape), np.nan) for each in found}
        return cls(values, [""] * count, np.zeros(count, dtype=bool))

    def part(self, places: NDArray[np.intp]) -> Batch:
        """Return the results of some of the samples."""
        values = {name: each[places] for name, each in self.values.items()}
        return Batch(values, [self.reason[k] for k in places], self.outside[places])

    def refuse(self, places: Sequence[int], why: str) -> None:
        """Give some of the samples a reason why they have no results, if they have none yet."""
        for k in places:
            self.reason[k] = self.reason[k] or why

    def add(self, places: Sequence[int], columns: Sequence[int], found: Batch) -> None:
        """Add results of the modes `columns` of some samples; the other modes are at rest."""
        for name in found.values.keys() & self.values.keys():
            at_rest = np.nan if name.endswith(("_phase", "_frequency")) else 0.0
            self.values[name][places] = at_rest
            self.values[name][np.ix_(places, columns)] = found.values[name]
        self.outside[places] |= found.outside
        for k, why in zip(places, found.reason, strict=True):
            self.refuse([k], why)
