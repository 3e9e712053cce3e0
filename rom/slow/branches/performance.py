"""Performance curves of friction dampers: the resonance peak against limits or preloads.

With a homogeneous law the peak is a(F, s N) = s a(F / s, N), so one backbone has the peak for
every friction limit or preload s N. In phase resonance the force balances the losses, |F| =
4 zeta Omega^2 a: each amplitude of the backbone is a point with s = |F| / (4 zeta Omega^2 a).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.contact.slip_onset import slip_onset
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.nonlinear.stiffness import refuse_nonlinear_stiffness
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.answer_error import peak_errors
from slipmode.rom.slow.branches.backbone import (
    Backbone,
    phase_resonance,
    phase_resonances,
    refuse_lost,
)
from slipmode.rom.slow.branches.curve_result import (
    ModeCurve,
    axes_or_current,
    label_point,
    plot_band,
)
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.units import MODAL_AMPLITUDES, SI, Shown, Units
from slipmode.rom.table.model import Model
from slipmode.rom.validity import warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@frozen
class PerformanceCurve(ModeCurve):
    """Hold the resonance peaks of a mode against a factor on all friction limits and preloads.

    Attributes
    ----------
    motion : SteadyMotion
        Motion of all DOFs at the peaks.
    mode : int
        0 for A, 1 for B.
    limit : (n,) ndarray
        Factor on the limits and preloads of the model [-], ascending unless the curve has folds.
    peak : (n,) ndarray
        Peak amplitudes |a| [kg^1/2 m].
    error : (n,) ndarray
        Error of the peak at a constant factor, due to the errors of the backbone [kg^1/2 m].
    frequency : (n,) ndarray
        Frequencies of the peaks [rad/s].
    """

    limit: Floats
    peak: Floats
    error: Floats
    frequency: Floats

    @property
    def optimum(self) -> tuple[float, float]:
        """Factor [-] with the lowest peak |a| [kg^1/2 m]; no optimum if `is_cut_at_lowest`."""
        return self.lowest()

    @property
    def optimum_range(self) -> tuple[float, float]:
        """Range of factors [-] whose peaks equal the lowest peak within the error."""
        return self.lowest_range()

    def lowest(self, shown: Shown = MODAL_AMPLITUDES) -> tuple[float, float]:
        """Return the factor with the lowest resonance peak, and this peak.

        Parameters
        ----------
        shown : Shown
            Peaks |a|, or displacement amplitudes of a DOF in given units. Default: |a| [kg^1/2 m].

        Returns
        -------
        factor : float
            Factor on friction limits and preloads [-].
        peak : float
            Lowest peak, in the units of `shown`.
        """
        size = self.size(shown)
        at = int(np.argmin(size))
        return float(self.limit[at]), float(size[at])

    def is_cut_at_lowest(self, shown: Shown = MODAL_AMPLITUDES) -> bool:
        """Return whether the lowest peak is at the smallest factor, where the curve is cut off.

        Smaller factors may then have lower peaks, so that this peak is not an optimum.

        Parameters
        ----------
        shown : Shown
            Peaks |a|, or displacement amplitudes of a DOF in given units. Default: |a| [kg^1/2 m].

        Returns
        -------
        bool
            True if the curve has no optimum within its range.
        """
        return int(np.argmin(self.size(shown))) == int(np.argmin(self.limit))

    def lowest_words(self, shown: Shown = MODAL_AMPLITUDES) -> str:
        """Return the factor of the lowest peak, or of the end of the curve, in words for plots."""
        words = "still falls" if self.is_cut_at_lowest(shown) else "lowest"
        return f"{words} at {self.lowest(shown)[0]:.3g}"

    def lowest_range(self, shown: Shown = MODAL_AMPLITUDES) -> tuple[float, float]:
        """Return the range of factors whose peaks equal the lowest peak within the error.

        Parameters
        ----------
        shown : Shown
            Peaks |a|, or displacement amplitudes of a DOF in given units. Default: |a| [kg^1/2 m].

        Returns
        -------
        first, last : float
            Ends of the range of factors [-].
        """
        size = self.size(shown)
        error, best = self.error_of(size), int(np.argmin(size))
        return self._around(best, size - error > size[best] + error[best])

    def within(self, factor: float, shown: Shown = MODAL_AMPLITUDES) -> tuple[float, float]:
        """Return the range of factors whose peaks are at most a multiple of the lowest peak.

        Parameters
        ----------
        factor : float
            Largest peak relative to the lowest [-], for instance 1.05.
        shown : Shown
            Peaks |a|, or displacement amplitudes of a DOF in given units. Default: |a| [kg^1/2 m].

        Returns
        -------
        first, last : float
            Ends of the range of factors on friction limits and preloads [-].
        """
        size = self.size(shown)
        best = int(np.argmin(size))
        return self._around(best, size > factor * size[best])

    def _around(self, at: int, is_worse: Flags) -> tuple[float, float]:
        """Return the range of factors around a point up to points that are worse."""
        worse, size = np.flatnonzero(is_worse), self.limit
        first = worse[worse < at].max(initial=-1) + 1
        last = worse[worse > at].min(initial=size.size) - 1
        low, high = sorted((float(self.limit[first]), float(self.limit[last])))
        return low, high

    def plot(self, ax: Axes | None = None, dof: int | None = None, units: Units = SI) -> Axes:
        """Plot the resonance peak against the factor, with its error and the optimum.

        Parameters
        ----------
        ax : Axes, optional
            Matplotlib axes. Default: the current axes.
        dof : int, optional
            DOF whose displacement amplitude is plotted. Default: |a| of the mode.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        Axes
            Axes of the plot.
        """
        ax, shown = axes_or_current(ax), Shown(dof, units)
        peak, lowest = self.size(shown), self.lowest(shown)
        plot_band(ax, self.limit, peak, self.error_of(peak), 0.01 * peak)  # logarithmic
        ax.loglog(self.limit, peak)
        (point,) = ax.loglog(*lowest, "o")
        label_point(ax, self.lowest_words(shown), lowest, point.get_color(), -8.0)
        name = shown.named("resonance peak")
        ax.set(xlabel="friction limits, preloads: factor [-]", ylabel=name)
        ax.margins(y=0.15)
        return ax

    def _values(self, units: Units) -> dict[str, Floats]:
        found = {"limit": self.limit, "peak": self.peak, "peak_error": self.error}
        return found | units.frequencies(frequency=self.frequency)

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        sizes = self.size(Shown(dof, units))
        return {"peak": sizes, "peak_error": self.error_of(sizes)}

    def error_of(self, size: Floats) -> Floats:
        """Return the error of peaks that have the relative error of |a|.

        Parameters
        ----------
        size : (n,) ndarray
            Peaks, in any unit.

        Returns
        -------
        (n,) ndarray
            Errors, in the unit of `size`.
        """
        return size * self.error / self.peak


def performance_curve(
    model: Model, force: Mapping[int, float] | ArrayLike, mode: int = 0
) -> PerformanceCurve:
    """Return the resonance peak under a constant force against friction limits or preloads.

    The curve shows the limit with the lowest peak, for the design of friction dampers.

    Parameters
    ----------
    model : Model
        Model whose friction scales with its limits: not Tanh, and without gaps. A wider amplitude
        range gives a wider curve.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes at the frequency of the mode [N].
    mode : int, default 0
        0 for A, 1 for B. The other mode is at rest.

    Returns
    -------
    PerformanceCurve
        Peaks with their errors and frequencies.

    Raises
    ------
    SlipmodeError
        If the law does not scale, or the force does not act on the mode. If the mode is
        self-excited or undamped, or contacts hardly slip within the friction table. If the force
        acts so strongly on the contacts that a frequency does not converge.

    Warns
    -----
    ValidityWarning
        If the curve ends where the error of the peak is as large as the peak, or where the peak
        still falls.

    Notes
    -----
    A peak is the phase resonance |F| = 4 zeta Omega^2 |a| of `rom.backbone`. Its relative error is
    of the order of the square of the damping ratio. Friction scales as |a|(F; s) = s |a|(F / s;
    1), so that one backbone gives the peaks for every factor s. See "Backbones" in docs/theory.md.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> model = rom.tabulate(reduced, rom.Coulomb(limit=2.0), amplitude=(12.0,))
    >>> curve = rom.performance_curve(model, {0: 0.15})
    >>> factor, peak = curve.optimum
    """
    refuse_nonlinear_stiffness(
        model.reduced, "rom.performance_curve", "compute rom.response_curve for each limit"
    )
    if not is_homogeneous(model.law, model.reduced.n_contacts):
        raise SlipmodeError(
            "law: the motion must scale with the limits, which excludes tanh and gaps; got "
            f"{model.law!r}"
        )
    model.check_mode(mode)
    F = abs(model.reduced.modal_force(mode, force))
    if F == 0.0:
        raise SlipmodeError(f"force: does not excite mode {'AB'[mode]}; choose another DOF")
    curve, _ = phase_resonances(model, mode)
    # Friction hardly changes the damping.
    if np.ptp(curve.damping) <= 0.01 * curve.damping.min():
        raise SlipmodeError(
            f"amplitude: up to {curve.amplitude[-1]:.3g} kg^1/2 m, the end of the friction table, "
            "contacts hardly slip, so every limit has the same peak and none is optimal; "
            f"{_advice(model, mode)}"
        )
    share = curve.damping_error / curve.damping + curve.frequency_error / curve.frequency
    (unknown,) = np.nonzero(share >= 1.0)  # errors as large as the peaks
    known = int(unknown[0]) if unknown.size else share.size
    if known < 2:
        raise SlipmodeError(
            f"model: the relative error of the peaks is {percentage(share[0])}; tabulate with a "
            "smaller tolerance"
        )
    forces: list[Mapping[int, float] | ArrayLike] = [{}] * model.modes
    forces[mode] = force
    applied = AppliedForces.of(model.reduced, forces)
    shift = complex(applied.shift[mode])  # of the contacts, by the force itself
    amplitude = curve.motion.amplitude[:known]
    start = ForcedFlow.of(model, curve.motion.frequency[:known])
    flow, force_ratio, found = phase_resonance(start, mode, amplitude, shift)
    refuse_lost(
        found,
        amplitude[:, mode],
        "the force acts more strongly on the contacts than on the mode; compute "
        "rom.response_curve for each limit",
    )
    peak = F / np.abs(force_ratio)
    limit = peak * np.abs(1.0 + shift * force_ratio) / curve.amplitude[:known]
    warn(_unknown_findings(curve, known, limit[-1]))
    error = peak_errors(limit, peak, share[:known])
    kept = np.flatnonzero(_significant(limit, limit * share[:known]))[::-1]
    limit, peak, error, frequency = limit[kept], peak[kept], error[kept], flow.frequency[kept]
    amplitude = np.zeros_like(flow.force[kept])
    amplitude[:, mode] = peak
    force_ahead = np.tile(1j * np.abs(applied.modal), (limit.size, 1))  # by a quarter of a cycle
    motion = SteadyMotion(model, amplitude, frequency, force_ahead, applied, limit)
    performance = PerformanceCurve(motion, mode, limit, peak, error, frequency[:, mode])
    if performance.is_cut_at_lowest():
        reason = "the curve ends there, and smaller limits may have lower peaks"
        if known == share.size:
            reason += "; tabulate a larger range"
        warn([Finding("peak", f"still falls at limit = {limit.min():.3g}", reason, "warning")])
    return performance


def _significant(limit: Floats, error: Floats) -> Flags:
    """Return which points to keep, (n,), so that peaks fold over only by more than the error.

    Between two turning points of the limit, or one and an end, that are closer than the error of
    the limit, the curve is left out, with its neighbours at the same limits.
    """
    kept = np.ones(limit.size, dtype=bool)
    while True:
        at = np.flatnonzero(kept)
        way = np.sign(np.diff(limit[at]))
        turns = at[np.r_[0, np.flatnonzero(way[1:] != way[:-1]) + 1, at.size - 1]]
        if turns.size == 2:
            return kept
        first, second = turns[:-1], turns[1:]
        size = np.abs(limit[first] - limit[second]) / (error[first] + error[second])
        least = int(np.argmin(size))
        if size[least] > 1.0:
            return kept
        i, j = first[least], second[least]
        low, high = sorted((limit[i], limit[j]))
        others = np.flatnonzero(~kept | (limit < low) | (limit > high))
        before = others[others < i].max(initial=-1)
        after = others[others > j].min(initial=limit.size)
        kept[before + 1 : after] = False


def _unknown_findings(curve: Backbone, known: int, limit: float) -> list[Finding]:
    """Report where a curve ends because the error of its peaks is as large as they are."""
    if known == curve.amplitude.size:
        return []
    natural = curve.motion.model.reduced.carrier[curve.mode]
    apart = abs(curve.frequency[known] / natural - 1.0)
    reason = (
        "at smaller limits the error of the peak is as large as the peak, because the frequency "
        f"of the mode is {percentage(apart)} away from the reference frequency of the friction "
        f"table. Call rom.reduce with carrier = {curve.frequency[known]:.4g} rad/s"
    )
    return [Finding("curve", f"ends at limit = {limit:.3g}", reason, "warning")]


def _advice(model: Model, mode: int) -> str:
    """Return the advice for contacts that hardly slip."""
    first, last = slip_onset(model.reduced, model.law, mode)
    if first == 0.0:
        return "this mode does not move the contacts"
    # Friction dissipates most at about twice the onset: four times that is enough.
    return f"the first contact slips at {first:.3g}; tabulate to {4.0 * last:.2g} or more"
