"""Least squares of one model of loops, and intervals of its parameters from repeated cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from slipmode.rom.common import Floats, frozen
from slipmode.rom.identification.loops.loop import Strokes
from slipmode.rom.identification.loops.model import Joints, Terms, Values

LEVEL = 0.99  # of intervals
DIFFERENCE = 1e-4  # of logarithms, by which derivatives are computed
# Relative size of eigenvalues of the normal matrix that derivatives cannot tell from zero
SINGULAR = DIFFERENCE**2
UNKNOWN = 0.01  # share of a parameter in these directions from which it is not determined


@frozen
class Fitted:
    """A model that was fitted to the strokes of all levels.

    Attributes
    ----------
    terms : Terms
    levels : sequence of Strokes
    logarithms : (coordinates,) ndarray
        Logarithms of the values of `terms.names`.
    """

    terms: Terms
    levels: Sequence[Strokes]
    logarithms: Floats

    @classmethod
    def of(cls, terms: Terms, levels: Sequence[Strokes], start: Values) -> Fitted:
        """Return the fit from initial values of the coordinates."""
        initial = np.log([start[name] for name in terms.names(len(levels))])
        fit = cls(terms, levels, initial)

        def residuals(p: Floats) -> Floats:
            return np.concatenate([r[0] for r in fit.residuals(p[np.newaxis])])

        def slopes(p: Floats) -> Floats:
            return np.concatenate(fit.slopes(p))

        # Logarithms far from the initial ones belong to terms without influence.
        bounds = (initial - 12.0, initial + 12.0)
        found = scipy.optimize.least_squares(
            residuals, initial, slopes, bounds, ftol=1e-6, xtol=1e-6
        )
        return replace(fit, logarithms=found.x)

    def on(self, levels: Sequence[Strokes]) -> Fitted:
        """Return the fit of the model to other samples of the levels."""
        return Fitted.of(self.terms, levels, self.values)

    @property
    def values(self) -> Values:
        """Values of the coordinates by name."""
        return self._named(np.exp(self.logarithms))

    def _named(self, values: Floats) -> Values:
        names = self.terms.names(len(self.levels))
        return dict(zip(names, values.tolist(), strict=True))

    @property
    def errors(self) -> Floats:
        """Rms error of each level relative to its peak force, (levels,)."""
        return np.array([np.sqrt(np.mean(r**2)) for r in self.residuals()])

    @property
    def error(self) -> float:
        """Rms of the errors of all levels."""
        return float(np.sqrt(np.mean(self.errors**2)))

    def limits(self, level: int, values: Values) -> tuple[float, float]:
        """Return the friction limits of a level, forward and backward [N]."""
        ways = ("forward", "backward") if self.terms.direction else ("limit", "limit")
        forward, backward = (values[f"{level}.{way}"] for way in ways)
        return forward, backward

    def forces(self, level: int, variants: Floats | None = None) -> Floats:
        """Return the forces of a level after its run-in (variants, samples) [N].

        `variants` (variants, coordinates) are logarithms, by default of the fit.
        """
        variants = self.logarithms[np.newaxis] if variants is None else variants
        every = [self._named(each) for each in np.exp(variants)]
        sliders = [self.terms.sliders(values) for values in every]
        k, share = (np.array(each) for each in zip(*sliders, strict=True))
        forward, backward = np.array([self.limits(level, values) for values in every]).T
        strokes = self.levels[level]
        joints = Joints(
            stiffness=k,
            low=-share * backward[:, np.newaxis] / k,
            high=share * forward[:, np.newaxis] / k,
            backlash=np.array([values.get(f"{level}.backlash", 0.0) for values in every]),
            spring=np.array([values.get("spring", 0.0) for values in every]),
            middle=strokes.middle,
        )
        return joints.forces(strokes.displacement)[:, -strokes.used_force.size :]

    def residuals(self, variants: Floats | None = None) -> list[Floats]:
        """Return the errors of the forces of each level, relative to its peak force."""
        return [
            (self.forces(i, variants) - level.used_force) / level.peak
            for i, level in enumerate(self.levels)
        ]

    def slopes(self, logarithms: Floats) -> list[Floats]:
        """Return the derivatives (samples, coordinates) of the residuals by the logarithms."""
        steps = DIFFERENCE * np.eye(logarithms.size)
        variants = logarithms + np.concatenate([np.zeros_like(steps[:1]), steps])
        return [(r[1:] - r[0]).T / DIFFERENCE for r in self.residuals(variants)]

    def parameters(self) -> Values:
        """Return the parameters by the names that users see."""
        return dict(zip(self._names(), self._shown(self.logarithms).tolist(), strict=True))

    def _names(self) -> list[str]:
        numbers = range(1, self.terms.elements + 1)
        names = ["stiffness", "chi", "beta"] if not numbers else ["stiffness"]
        if len(numbers) > 1:
            names = [f"{name}_{i}" for name in ("stiffness", "share") for i in numbers]
        names += ["spring"] if self.terms.spring else []
        own = ["backlash"] if self.terms.backlash else []
        own += ["limit_forward", "limit_backward"] if self.terms.direction else ["limit"]
        several = len(self.levels) > 1
        return names + [
            f"{level.name}.{each}" if several else each for level in self.levels for each in own
        ]

    def _shown(self, logarithms: Floats) -> Floats:
        """Return the parameters of `_names`, (parameters,)."""
        values, terms = self._named(np.exp(logarithms)), self.terms
        own = [values.get(name) for name in ("stiffness", "chi", "beta")]
        if terms.elements:
            k, share = terms.sliders(values)
            own = [*k, *share] if terms.elements > 1 else [*k]
        else:
            own[1] = terms.iwan(values, 1.0).chi
        rest = list(values.values())[len(terms.names(0)) - terms.spring :]
        return np.array([*own, *rest])

    def intervals(self) -> dict[str, tuple[float, float]]:
        """Return the intervals of the parameters; infinite if the data do not determine them.

        They follow from the scatter of the cycles: the sums of residuals times derivatives over
        each cycle differ between cycles only by what is not repeated.
        """
        slopes = self.slopes(self.logarithms)
        matrix = sum(J.T @ J for J in slopes)
        scatter = np.zeros_like(matrix)
        for level, J, (r,) in zip(self.levels, slopes, self.residuals(), strict=True):
            cycle, n = level.cycle_of_sample(), level.cycles
            gradients = np.array([J[cycle == i].T @ r[cycle == i] for i in range(n)])
            gradients -= gradients.mean(axis=0)
            scatter += n / max(n - 1, 1) * gradients.T @ gradients
        size = np.sqrt(np.diag(matrix))
        size[size == 0.0] = 1.0
        eigenvalues, vectors = np.linalg.eigh(matrix / np.multiply.outer(size, size))
        known = eigenvalues > SINGULAR * eigenvalues.max()
        inverse = (vectors[:, known] / eigenvalues[known]) @ vectors[:, known].T
        inverse /= np.multiply.outer(size, size)
        covariance = inverse @ scatter @ inverse
        shown = self._shown(self.logarithms)
        moved = [self._shown(self.logarithms + step) for step in DIFFERENCE * np.eye(size.size)]
        # An interval of a logarithm has positive ends; chi may be negative.
        offset = np.array([float(name == "chi") for name in self._names()])
        G = np.log((np.array(moved) + offset) / (shown + offset)).T / DIFFERENCE
        along = (G / size) @ vectors
        free = (along[:, ~known] ** 2).sum(axis=1) > UNKNOWN * (along**2).sum(axis=1)
        fewest = min(level.cycles for level in self.levels)
        quantile = float(scipy.special.stdtrit(max(fewest - 1, 1), 0.5 + 0.5 * LEVEL))
        half = quantile * np.sqrt(np.maximum(np.diag(G @ covariance @ G.T), 0.0))
        half[free | (fewest < 2)] = np.inf  # one cycle has no scatter
        low, high = ((shown + offset) * np.exp(way * half) - offset for way in (-1.0, 1.0))
        ends = zip(low.tolist(), high.tolist(), strict=True)
        return dict(zip(self._names(), ends, strict=True))
