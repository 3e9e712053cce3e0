"""Resonance curves of the paper's model, and how they depend on alpha and beta."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.paper.case import FORCE, Case
from slipmode import rom
from slipmode.rom.arrays import Floats

FAR = 0.2  # a detuning far from resonance [rad/s]
DETUNINGS = np.linspace(-FAR, FAR, 401)
ALPHAS = (0.005, 0.01, 0.02, 0.05)  # [m/s]
BETAS = (0.008, 0.0095, 0.0109, 0.0125, 0.015)  # [s]


def moduli(model: rom.Model, detuning_a: ArrayLike, detuning_b: ArrayLike) -> Floats:
    """Return steady |A|, |B| (..., 2) under the forces of Table 1 at detunings [rad/s]."""
    detuning = np.stack(np.broadcast_arrays(detuning_a, detuning_b), axis=-1)
    forces = ({0: FORCE[0]}, {1: FORCE[1]})
    return np.abs(rom.steady(model, model.reduced.frequency + detuning, forces))


def euclidean(amplitudes: Floats) -> Floats:
    """Return sqrt(|A|^2 + |B|^2)."""
    return np.asarray(np.linalg.norm(amplitudes, axis=-1))


def peak(amplitudes: Floats) -> tuple[float, float]:
    """Return detuning [rad/s] and height of the highest Euclidean norm of a slice."""
    norm = euclidean(amplitudes)
    top = int(norm.argmax())
    return float(DETUNINGS[top]), float(norm[top])


@dataclass(frozen=True, eq=False)
class Slices:
    """|A|, |B| (n, 2) along the detuning of A or of B, lines of the resonance surface.

    The other mode is far below (A) or above (B) its resonance, or at its peak.
    """

    alone_a: Floats
    alone_b: Floats
    both_a: Floats
    both_b: Floats

    @classmethod
    def of(cls, model: rom.Model) -> Self:
        """Return the slices of the surface of a model."""
        alone_a = moduli(model, DETUNINGS, -FAR)
        alone_b = moduli(model, FAR, DETUNINGS)
        both_a = moduli(model, DETUNINGS, peak(alone_b)[0])
        return cls(alone_a, alone_b, both_a, moduli(model, peak(alone_a)[0], DETUNINGS))

    @property
    def peak_a(self) -> float:
        """Height of the peak of A alone."""
        return peak(self.alone_a)[1]

    @property
    def detuning_b(self) -> float:
        """Detuning of the peak of B alone [rad/s]."""
        return peak(self.alone_b)[0]

    @property
    def summed_peaks(self) -> float:
        """The linear superposition of the paper: peak of A alone plus peak of B alone."""
        return self.peak_a + peak(self.alone_b)[1]

    @property
    def peak_gain(self) -> float:
        """Relative change of the peak of A by mode B at resonance."""
        return peak(self.both_a)[1] / self.peak_a - 1

    @property
    def excess_of_norms(self) -> tuple[float, float]:
        """Superposition over the coupled peak, less 1: in |A|+|B| and in sqrt(|A|^2+|B|^2)."""
        top = np.array([self.alone_a[:, 0].max(), self.alone_b[:, 1].max()])
        summed, euclid = self.both_a.sum(axis=1).max(), euclidean(self.both_a).max()
        return float(top.sum() / summed) - 1, float(euclidean(top) / euclid) - 1

    @property
    def rise_at_b(self) -> float:
        """Amplitude of both at the resonance of B over the least within 0.1 rad/s, less 1."""
        norm = euclidean(self.both_b)
        resonance = float(np.interp(self.detuning_b, DETUNINGS, norm))
        return resonance / float(norm[np.abs(DETUNINGS - self.detuning_b) < 0.1].min()) - 1


class Sensitivity:
    """Slices over ALPHAS x BETAS; damping does not enter the paper's friction tables."""

    def __init__(self) -> None:
        models = [Case(alpha=alpha, tolerance=3e-3).paper for alpha in ALPHAS]
        self._slices = [[Slices.of(_with_damping(m, beta)) for beta in BETAS] for m in models]

    def of(self, quantity: Callable[[Slices], float]) -> Floats:
        """Return a number of the slices, (alphas, betas)."""
        return np.array([[quantity(slices) for slices in row] for row in self._slices])


def _with_damping(model: rom.Model, beta: float) -> rom.Model:
    """The same friction with another structural damping: phi^T beta K phi = beta omega^2."""
    damping = beta * model.reduced.frequency**2
    return replace(model, reduced=replace(model.reduced, modal_damping=damping))
