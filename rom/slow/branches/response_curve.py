"""Response curves: all steady states against a frequency, a force or the friction limit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import dataframe, extra
from slipmode.rom.reduction.force_response import Forces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import off_carrier_findings
from slipmode.rom.slow.branches.backbone import BAND
from slipmode.rom.slow.branches.continuation import (
    MOST_POINTS,
    Branch,
    Kind,
    Points,
    branch_through,
)
from slipmode.rom.slow.branches.curve_error import CurveError, significant_specials
from slipmode.rom.slow.branches.forced import LARGEST_STEP, ForcedSlowFlow, Varied
from slipmode.rom.slow.branches.oscillation import SlowCycles, slow_cycles
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.model import Model
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import Finding, forcing_findings, friction_findings, warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@frozen
class SpecialPoint:
    """Where stability changes.

    Attributes
    ----------
    kind : {"fold", "Hopf"}
        The curve turns back; the amplitudes begin to oscillate.
    parameter : float
        As in ResponseCurve.
    amplitude : (modes,) complex ndarray
        a_j [kg^1/2 m].
    """

    kind: Kind
    parameter: float
    amplitude: Complexes


@frozen
class CurveSizes:
    """Amplitudes of points, special points and slow cycles of a curve, each (n, modes)."""

    points: Floats
    special: Floats
    lowest: Floats
    highest: Floats


@frozen
class ResponseCurve:
    """Steady states against a varied parameter, branch after branch.

    Attributes
    ----------
    vary : str
    parameter : (n,) ndarray
        Its values: [rad/s], or relative to the forces and limits given [-].
    amplitude : (n, modes) complex ndarray
        a_j [kg^1/2 m].
    error : (n, modes) ndarray
        Of a_j at a constant parameter: |a_j - exact| by the errors of the friction table and of
        forcing off its carriers [kg^1/2 m].
    growth : (n,) ndarray
        Largest growth rate of small deviations [1/s]. Interpolated between folds and between
        Hopf points that are left out because they are closer than the error.
    branch : (n,) ndarray of int
        Neighbours of one branch follow one another along the curve.
    special : tuple of SpecialPoint
    mode_shapes : (n_dofs, modes) ndarray
        [kg^-1/2]
    cycles : SlowCycles
        Ranges of amplitudes that oscillate in slow time, beyond Hopf points.
    cut_off : (n,) ndarray
        Values of the parameter at which a branch with too many points ends early.
    motion : SteadyMotion
        At the points of the curve, then at `special`, then at the least and the largest
        amplitudes of `cycles`, without force because its phase is not known.
    """

    vary: str
    parameter: Floats
    amplitude: Complexes
    error: Floats
    growth: Floats
    branch: NDArray[np.intp]
    special: tuple[SpecialPoint, ...]
    mode_shapes: Floats
    cycles: SlowCycles
    cut_off: Floats
    motion: SteadyMotion

    @property
    def stable(self) -> Flags:
        """Whether motion near a steady state tends to it, (n,)."""
        return np.asarray(self.growth < 0.0)

    def at(self, value: float) -> tuple[Complexes, Flags]:
        """Return steady states at a value of the parameter, (found, modes), and which are stable.

        Interpolated linearly between points of the curve, with errors of some 1e-4.
        """
        p = self.parameter
        across = (p[:-1] > value) != (p[1:] > value)
        (before,) = np.nonzero(across & (self.branch[:-1] == self.branch[1:]))
        part = ((value - p[before]) / (p[before + 1] - p[before]))[:, np.newaxis]
        a = (1.0 - part) * self.amplitude[before] + part * self.amplitude[before + 1]
        return a, self.stable[np.where(part[:, 0] < 0.5, before, before + 1)]

    def displacement(self, dof: int) -> Floats:
        """Return the amplitude of a DOF at the carrier of each mode, (n, modes) [m]."""
        return self.sizes(Shown(dof)).points

    def error_of(self, size: Floats) -> Floats:
        """Return the error of amplitudes `size` (n, modes), with the relative error of a_j."""
        modulus = np.abs(self.amplitude)
        return size * np.divide(self.error, modulus, out=np.zeros_like(size), where=modulus > 0.0)

    def sizes(self, shown: Shown) -> CurveSizes:
        """Return everything that a picture of the curve shows, |a_j| or the amplitude of a DOF."""
        counts = self.parameter.size, len(self.special), self.cycles.parameter.size
        return CurveSizes(*np.split(shown.size(self.motion), np.cumsum(counts)))

    @property
    def _is_frequency(self) -> bool:
        return self.vary.startswith("frequency_")

    def in_units(self, parameter: ArrayLike, units: Units) -> Floats:
        """Return values of the parameter as pictures and tables show them."""
        return units.of_frequency(parameter) if self._is_frequency else np.asarray(parameter)

    def label(self, units: Units) -> str:
        """Return the parameter in words, with its unit."""
        unit = units.frequency if self._is_frequency else "-"
        return f"{self.vary.replace('_', ' ')} [{unit}]"

    def plot(self, ax: Axes | None = None, dof: int | None = None, units: Units = SI) -> Axes:
        """Draw |a_j|, or the amplitude of a DOF, against the parameter.

        Stable states are solid, unstable ones dashed; folds are circles, Hopf points squares.
        Bands show the error. Bars show the range of amplitudes that oscillate in slow time.
        """
        ax = extra("matplotlib.pyplot", "pictures").gca() if ax is None else ax
        shown, parameter = Shown(dof, units), self.in_units(self.parameter, units)
        sizes = self.sizes(shown)
        error = self.error_of(sizes.points)
        for j in range(self.amplitude.shape[1]):
            size, color = sizes.points[:, j], f"C{j}"
            low, high = size - error[:, j], size + error[:, j]
            for number in np.unique(self.branch):
                own = self.branch == number
                ax.fill_between(parameter[own], low[own], high[own], color=color, alpha=BAND, lw=0)
                for which, style in ((self.stable, "-"), (~self.stable, "--")):
                    part = np.where(which, size, np.nan)[own]
                    ax.plot(parameter[own], part, style, color=color)
            where = self.in_units(self.cycles.parameter, units)
            low, high = sizes.lowest[:, j], sizes.highest[:, j]
            ax.vlines(where, low, high, color=color, alpha=0.3, lw=3)
            top = int(np.argmax(size))
            ax.annotate(
                f"|{'AB'[j]}|",
                (parameter[top], size[top]),
                xytext=(0, 4),
                textcoords="offset points",
                color=color,
                ha="center",
            )
            for point, height in zip(self.special, sizes.special[:, j], strict=True):
                marker = {"fold": "o", "Hopf": "s"}[point.kind]
                ax.plot(self.in_units(point.parameter, units), height, marker, color=color)
        ax.set(xlabel=self.label(units), ylabel=shown.named("amplitude"), ylim=(0.0, None))
        ax.margins(y=0.1)
        for kind, marker in (("fold", "o"), ("Hopf", "s")):
            if any(point.kind == kind for point in self.special):
                ax.plot([], [], marker, color="0.4", label=f"{kind} point")
        if not self.stable.all():
            ax.plot([], [], "--", color="0.4", label="unstable")
        if ax.get_legend_handles_labels()[0]:
            ax.legend()
        return ax

    def columns(self, dof: int | None = None, units: Units = SI) -> dict[str, Any]:
        """Return columns by name, with the amplitude of a DOF in each mode if one is given."""
        name = units.named(self.vary) if self._is_frequency else self.vary
        found: dict[str, Any] = {name: self.in_units(self.parameter, units), "branch": self.branch}
        for j, mode in enumerate("AB"[: self.amplitude.shape[1]]):
            found |= {f"{mode}_re": self.amplitude[:, j].real}
            found |= {f"{mode}_im": self.amplitude[:, j].imag}
            found |= {f"{mode}_error": self.error[:, j]}
        if dof is not None:
            sizes = units.of_displacement(self.displacement(dof))
            errors = self.error_of(sizes)
            for mode, size, error in zip("AB", sizes.T, errors.T, strict=False):
                found[units.of_dof(mode, dof)] = size
                found[units.of_dof(f"{mode} error", dof)] = error
        return found | {"growth": self.growth}

    def to_dataframe(self, dof: int | None = None, units: Units = SI) -> Any:
        """Return a table with a row per steady state; see `columns`."""
        return dataframe(self.columns(dof, units) | {"stable": self.stable})


def response_curve(
    model: Model,
    frequency: ArrayLike,
    force: Forces,
    vary: Varied,
    span: Sequence[ArrayLike],
    phase: ArrayLike = 0.0,
    largest_step: float = LARGEST_STEP,
) -> ResponseCurve:
    """Follow every steady state within the friction table, through folds, with its stability.

    Steady states are searched from many amplitudes and phases at several values of the span, which
    also finds branches that no sweep reaches. A branch between two such values may not be found.

    Parameters
    ----------
    model : Model
        Its carriers should be near the forcing: errors reach 7 % where a strong contact lifts
        off and the forcing is 3 % away.
    frequency : (modes,) array_like
        Forcing frequencies [rad/s]; a varied one is ignored.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N] as in `steady`.
    vary : str
        "frequency_A" or "frequency_B": one of them [rad/s]; "frequency": both, along the line
        between two points (modes,), the parameter its part from 0 to 1; "force_A", "force_B",
        "force": a factor on the forces; "limit": a factor on friction limits and preloads.
    span : pair
        First and last value.
    phase : float or (modes,) array_like
        Phases of the forces [rad].
    largest_step : float
        From one point to the next, over the whole span and the range of the table: 1e-4 to 0.1;
        they are closer where the curve bends.

    Returns
    -------
    ResponseCurve
        It ends where an amplitude leaves the table, or after 5000 points on a side: `cut_off`.

    Raises
    ------
    SlipmodeError
        If no steady state is found, or the slow flow cannot follow a frequency.

    Warns
    -----
    ValidityWarning
        Where friction or the force violates an assumption of the method, or a branch has too many
        points.
    """
    if not 1e-4 <= as_floats("largest_step", largest_step) <= 0.1:
        raise SlipmodeError(f"largest_step: must be 1e-4 to 0.1, got {largest_step}")
    problem = ForcedSlowFlow.of(model, frequency, force, phase, vary, span, largest_step)
    branches: list[Branch] = []
    left = problem.solutions(9)  # at nine values of the parameter
    while left.size:
        branch = branch_through(problem.curve, left[0])
        left = left[1:]
        if branch is not None and len(branch.points.rows) > 1:
            branches.append(branch)
            left = left[~branch.points.pass_by(left)]
    if not branches:
        raise SlipmodeError(
            f"span: no steady state inside the friction table, whose range is "
            f"{model.table.amplitude_range}, over the span {span}"
        )
    if problem.is_reversed:
        branches = [branch.reversed for branch in branches]
    rows = np.concatenate([branch.points.rows for branch in branches])
    points = Points(rows, problem.curve.unknowns)
    part, amplitude = points.z[:, -1], problem.amplitude(points.z)
    flow, forced = problem.at(part), (problem.ends.force != 0.0).any(axis=0)
    scale = flow.inputs["limit_scale"][:, np.newaxis]
    check_force_patterns(model, problem.applied, amplitude / scale, flow.force / scale)
    warn(friction_findings(model.reduced, model.law, (np.abs(amplitude) / scale).max(axis=0)))
    warn(forcing_findings(model.reduced, problem.ends.frequency, forced))
    number = np.repeat(np.arange(len(branches)), [len(each.points.rows) for each in branches])
    error = CurveError.of(problem, points.z, number)
    apart = (problem.ends.frequency / model.reduced.carrier - 1.0)[:, forced]
    warn(
        off_carrier_findings(model.accuracy.tolerance, error.off_carriers, apart, "amplitudes are")
    )
    cut_off = problem.parameter(np.array(_cut_off(branches)))
    if cut_off.size:
        where = f"{vary} = {', '.join(f'{value:.6g}' for value in cut_off)}"
        reason = (
            f"a branch has more than {MOST_POINTS} points; a shorter span shows where it goes on"
        )
        warn([Finding("curve", f"not followed beyond {where}", reason, "warning")])
    specials, smaller = significant_specials(problem, branches, error)
    at = np.array([z for _, z in specials]).reshape(-1, points.z.shape[1])
    values, amplitudes = problem.parameter(at[:, -1]).tolist(), problem.amplitude(at)
    special = tuple(
        SpecialPoint(kind, value, a)
        for (kind, _), value, a in zip(specials, values, amplitudes, strict=True)
    )
    cycles = slow_cycles(problem, Points(rows[~smaller], points.unknowns))
    growth = points.eigenvalues[:, 0].real
    if smaller.any():
        every = np.arange(growth.size)
        growth = np.where(smaller, np.interp(every, every[~smaller], growth[~smaller]), growth)
    return ResponseCurve(
        vary,
        problem.parameter(part),
        amplitude,
        error.amplitude,
        growth,
        number,
        special,
        model.reduced.mode_shapes.copy(),
        cycles,
        cut_off,
        _motion(problem, np.vstack((points.z, at)), cycles),
    )


def _motion(problem: ForcedSlowFlow, z: Floats, cycles: SlowCycles) -> SteadyMotion:
    """Return steady states z, then the ends of cycles, whose force is not known."""
    at_cycles = np.tile(problem.part(cycles.parameter), 2)
    flow = problem.at(np.append(z[:, -1], at_cycles))
    force = flow.force
    force[len(z) :] = 0.0
    return SteadyMotion(
        problem.model,
        np.concatenate([problem.amplitude(z), cycles.lowest, cycles.highest]),
        flow.frequency,
        force,
        problem.applied,
        flow.inputs["limit_scale"],
    )


def _cut_off(branches: list[Branch]) -> list[float]:
    """Return parts of the span where a curve continues, and no other branch covers it."""
    return [
        float(end[-1])
        for branch in branches
        for end in branch.cut_off
        if not any(
            other.points.pass_by(end[np.newaxis])[0] for other in branches if other is not branch
        )
    ]
