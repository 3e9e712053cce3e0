"""What a study asks of each sample, and the arrays that the answers fill."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from slipmode.rom.arrays import Floats

MODAL = "kg^1/2 m"


@dataclass(frozen=True)
class Curve:
    """Steady states at frequencies of a mode's force, those of the other held [rad/s]."""

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
    """An array of results: one entry per sample and the other dimensions; its unit, meaning."""

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    unit: str
    meaning: str


@dataclass(frozen=True)
class Asked:
    """The outputs of a study.

    Attributes
    ----------
    steady : bool
        Steady amplitudes under the forces at the end of the scene.
    resonance : tuple of str
        Modes whose highest resonance peak under its force is wanted, the other at rest.
    curve : Curve or None
    peak : bool
        Largest amplitudes of the run.
    times : tuple of float
        Times of the run at which amplitudes are wanted [s].
    recording : bool
        A recording of each run.
    dofs : tuple of int
        DOFs whose amplitude is wanted beside each modal one.
    """

    steady: bool = False
    resonance: tuple[str, ...] = ()
    curve: Curve | None = None
    peak: bool = False
    times: tuple[float, ...] = ()
    recording: bool = False
    dofs: tuple[int, ...] = ()

    KINDS: ClassVar = ("steady", "resonance", "curve", "peak", "times", "recording")
    KEYS: ClassVar = (*KINDS, "dofs")

    @property
    def anything(self) -> bool:
        """Whether there is an output at all."""
        return any(getattr(self, kind) for kind in self.KINDS)

    @property
    def runs(self) -> bool:
        """Whether samples are run through slow time on the model that they share."""
        return self.peak or bool(self.times)

    def results(self, modes: Sequence[str]) -> list[Result]:
        """The arrays, for the modes of the scene."""
        found: list[Result] = []
        mode, dof = ("mode", len(modes)), ("dof", len(self.dofs))

        def add(name: str, meaning: str, *more: tuple[str, int], unit: str = MODAL) -> None:
            dims = [mode, *more]
            sizes = tuple(n for _, n in dims)
            found.append(Result(name, tuple(d for d, _ in dims), sizes, unit, meaning))
            if self.dofs and unit == MODAL:
                words = f"{meaning}, at DOFs in the mode's shape"
                add(f"{name}_displacement", words, *more, dof, unit="m")

        if self.steady:
            add("steady", "steady amplitude |a|")
            add("steady_phase", "its phase", unit="rad")
        if self.resonance:
            add("resonance", "resonance peak |a|")
            add("resonance_frequency", "where it is", unit="rad/s")
        if self.curve:
            add("curve", "steady amplitude |a|", ("frequency", self.curve.points))
        if self.peak:
            add("peak", "largest |a| of the run")
        if self.times:
            add("at", "|a| at times of the run", ("time", len(self.times)))
        return found

    @property
    def chosen_from(self) -> tuple[str, ...]:
        """Single numbers of a sample, by the names that [choose] has for them."""
        kinds = [kind for kind in ("steady", "peak") if getattr(self, kind)]
        found = [f"{kind}_{mode}" for kind in kinds for mode in ("A", "B")]
        return (*found, *(f"resonance_{mode}" for mode in self.resonance))
