"""Performance curves of friction dampers: the resonance peak against what presses them.

A homogeneous law makes the peak a(F, s N) = s a(F / s, N): one backbone has it for every friction
limit or preload s N. In phase resonance the force feeds what is lost, |F| = 4 zeta Omega^2 a, so
that each amplitude of the backbone is a point of the curve, with s = |F| / (4 zeta Omega^2 a).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import dataframe, extra
from slipmode.rom.laws.friction import Friction, is_homogeneous
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.branches.backbone import LARGEST, SMALLEST, Backbone, backbone
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 2000
_ENOUGH = 4.0  # times where contacts begin to slip: friction takes most at about twice that
_MATTERS = 0.1  # of what the first to yield is moved by: others that matter are moved so much
_LITTLE = 0.01  # of the damping: friction that adds less has no best limit


@dataclass(frozen=True, eq=False)
class PerformanceCurve:
    """Resonance peaks of a mode by a factor on all friction limits and preloads.

    Attributes
    ----------
    limit : (n,) ndarray
        Factor on the model's limits and preloads [-], ascending unless peaks fold over.
    peak : (n,) ndarray
        |a| [kg^1/2 m].
    frequency : (n,) ndarray
        Where it is [rad/s].
    mode_shape : (n_dofs,) ndarray
        [kg^-1/2]
    motion : SteadyMotion
        Of all modes at the peaks.
    mode : int
        Which of them it is.
    """

    limit: Floats
    peak: Floats
    frequency: Floats
    mode_shape: Floats
    motion: SteadyMotion
    mode: int

    __repr__ = short_repr

    @property
    def optimum(self) -> tuple[float, float]:
        """The factor at which the peak |a| is lowest, and that peak."""
        return self.lowest()

    def lowest(self, shown: Shown | None = None) -> tuple[float, float]:
        """Return the factor at which the peak is lowest, and that peak, as it is shown: |a|."""
        size = self.size(shown)
        at = int(np.argmin(size))
        return float(self.limit[at]), float(size[at])

    def within(self, factor: float, shown: Shown | None = None) -> tuple[float, float]:
        """The range of limits around the optimum whose peaks are at most `factor` times its."""
        size = self.size(shown)
        at = int(np.argmin(size))
        worse = np.flatnonzero(size > factor * size[at])
        first = worse[worse < at].max(initial=-1) + 1
        last = worse[worse > at].min(initial=size.size) - 1
        low, high = sorted((float(self.limit[first]), float(self.limit[last])))
        return low, high

    def size(self, shown: Shown | None = None) -> Floats:
        """Return the peaks (n,) as they are shown; default: |a|."""
        return self.peak if shown is None else shown.size(self.motion)[:, self.mode]

    def displacement(self, dof: int) -> Floats:
        """Return the amplitude of a DOF at the peaks, (n,) [m]."""
        return self.motion.displacement(dof)[:, self.mode]

    def plot(self, ax: Axes | None = None, dof: int | None = None, units: Units = SI) -> Axes:
        """Peak against the factor, the optimum marked."""
        ax = extra("matplotlib.pyplot", "pictures").gca() if ax is None else ax
        shown = Shown(dof, units)
        peak = self.size(shown)
        ax.loglog(self.limit, peak)
        at = int(np.argmin(peak))
        ax.loglog(self.limit[at], peak[at], "o", label=f"lowest at {self.limit[at]:.3g}")
        name = shown.named("resonance peak")
        ax.set(xlabel="friction limits, preloads: factor [-]", ylabel=name)
        ax.legend()
        return ax

    def columns(self, dof: int | None = None, units: Units = SI) -> dict[str, Floats]:
        """By name, with the peak of a DOF where one is given."""
        found = {
            "limit": self.limit,
            "peak": self.peak,
            units.named("frequency"): units.of_frequency(self.frequency),
        }
        if dof is not None:
            found[units.of_dof("peak", dof)] = units.of_displacement(self.displacement(dof))
        return found

    def to_dataframe(self, dof: int | None = None, units: Units = SI) -> Any:
        """One row per factor; see `columns`."""
        return dataframe(self.columns(dof, units))


def performance_curve(
    model: Model, force: Mapping[int, float] | ArrayLike, mode: int = 0
) -> PerformanceCurve:
    """The resonance peak under a force, for every friction limit or preload, from one table.

    Peaks are taken at phase resonance, which is off by the square of the damping ratio; the
    other mode is at rest. Twice the force needs twice the limits, and has twice the peaks.

    Parameters
    ----------
    model : Model
        Of contacts that scale: not tanh, and no gap. The wider its range, the wider the curve.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes [N] at the mode's frequency.
    mode : int
        0 for A, 1 for B.

    Raises
    ------
    SlipmodeError
        If the law does not scale, the force does not move the mode, the mode is self-excited or
        undamped, or contacts hardly slip within the friction table.
    """
    if not is_homogeneous(model.law, model.reduced.n_contacts):
        raise SlipmodeError(
            f"law: must be one that scales with its limits, not tanh, and without gaps; got "
            f"{model.law!r}"
        )
    model.check_mode(mode)
    F = abs(model.reduced.modal_force(mode, force))
    if F == 0.0:
        raise SlipmodeError(f"force: does not move mode {'AB'[mode]}")
    curve, held = _phase_resonances(model, mode)
    if np.ptp(curve.damping) <= _LITTLE * curve.damping.min():
        raise SlipmodeError(
            f"amplitude: up to {curve.amplitude[-1]:.3g} kg^1/2 m, as far as the friction table "
            "goes, the contacts hardly slip: every limit has the same peak, none is best; "
            f"{_advice(model, mode)}"
        )
    limit = F / held[::-1]
    frequency, peak = curve.frequency[::-1], limit * curve.amplitude[::-1]
    motion = _at_peaks(model, mode, force, limit, curve.motion)
    return PerformanceCurve(limit, peak, frequency, curve.mode_shape, motion, mode)


def _at_peaks(
    model: Model,
    mode: int,
    force: Mapping[int, float] | ArrayLike,
    limit: Floats,
    free: SteadyMotion,
) -> SteadyMotion:
    """Motion at the peaks (n,): of the backbone, scaled, and the force a quarter turn ahead."""
    forces: list[Mapping[int, float] | ArrayLike] = [{}] * model.modes
    forces[mode] = force
    applied = AppliedForces.of(model.reduced, forces)
    return SteadyMotion(
        model,
        limit[:, np.newaxis] * free.amplitude[::-1],
        free.frequency[::-1],
        np.tile(1j * np.abs(applied.modal), (limit.size, 1)),
        applied,
        limit,
    )


def _advice(model: Model, mode: int) -> str:
    """What to do where contacts hardly slip."""
    first, last = slip_onset(model.reduced, model.law, mode)
    if first == 0.0:
        return "this mode does not move them"
    return f"the first yields at {first:.3g}: tabulate to {_ENOUGH * last:.2g} or more"


def slip_onset(reduced: Reduced, law: Friction, mode: int) -> tuple[float, float]:
    """Amplitudes [kg^1/2 m] at which the first contact yields, and the last of those that matter.

    By that mode alone; 0 if it moves none that anything holds.
    """
    yielding = onset_lines(reduced, law)[:, mode]
    first = yielding.max(initial=0.0)
    if first == 0.0:
        return 0.0, 0.0
    return float(1.0 / first), float(1.0 / yielding[yielding >= _MATTERS * first].min())


def resonance_peaks(model: Model, mode: int, force: Floats) -> tuple[Floats, Floats]:
    """The highest resonance peak of a mode under modal forces |F_j| (n,), the other mode at rest.

    Returns
    -------
    peak : (n,) ndarray
        |a| [kg^1/2 m]; NaN where it is outside the friction table.
    frequency : (n,) ndarray
        Where it is [rad/s].

    Raises
    ------
    SlipmodeError
        If the mode is self-excited or undamped.
    """
    curve, held = _phase_resonances(model, mode)
    r, Omega = np.append(0.0, curve.amplitude), np.append(curve.frequency[0], curve.frequency)
    held = np.append(0.0, held)
    least = np.minimum.accumulate(held[::-1])[::-1]  # of the forces from there on
    below = np.searchsorted(least, force, side="right") - 1  # the last amplitude they exceed
    inside = below < held.size - 1
    k = np.where(inside, below, 0)
    part = (force - held[k]) / (held[k + 1] - held[k])
    peak, frequency = (each[k] + part * (each[k + 1] - each[k]) for each in (r, Omega))
    return np.where(inside, peak, np.nan), np.where(inside, frequency, np.nan)


def _phase_resonances(model: Model, mode: int) -> tuple[Backbone, Floats]:
    """A backbone over the friction table, and the modal force that holds each amplitude of it."""
    largest = model.table.amplitude_range[mode]
    curve = backbone(
        model, mode, 0.0, np.geomspace(SMALLEST * largest, LARGEST * largest, _POINTS)
    )
    if np.any(curve.damping <= 0.0):
        r = curve.amplitude[curve.damping <= 0.0][0]
        raise SlipmodeError(
            f"mode: {'AB'[mode]} has no damping at |a| = {r:.3g} kg^1/2 m, so it has no resonance "
            "peak; rom.limit_cycles finds the limit cycles of self-excited modes"
        )
    return curve, 4.0 * curve.damping * curve.frequency**2 * curve.amplitude
