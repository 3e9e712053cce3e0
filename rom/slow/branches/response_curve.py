"""Response curves: all steady states against a frequency, a force or the friction limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import Forces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.branches import Branches
from slipmode.rom.slow.branches.continuation import (
    MOST_POINTS,
    Kind,
    Points,
    cut_off,
)
from slipmode.rom.slow.branches.curve_error import significant_specials
from slipmode.rom.slow.branches.curve_result import (
    CurveResult,
    Method,
    axes_or_current,
    label_point,
    methods,
    plot_band,
)
from slipmode.rom.slow.branches.forced import LARGEST_STEP, ForcedSlowFlow, Varied
from slipmode.rom.slow.branches.oscillation import SlowCycles, slow_cycles
from slipmode.rom.slow.direct.contact_friction import ContactSolutions
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.tone.tone_curve import ToneCurve, curve_of_tone
from slipmode.rom.slow.tone.tone_states import ToneForce
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.table.model import Model
from slipmode.rom.validity import Finding, forcing_findings, friction_findings, warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_MARKERS: dict[Kind, str] = {"fold": "o", "Hopf": "s"}


@frozen
class SpecialPoint:
    """Hold a point of a response curve where the stability changes.

    Attributes
    ----------
    kind : {"fold", "Hopf"}
        At a fold the curve turns back. At a Hopf point the amplitudes begin to oscillate.
    parameter : float
        Value of the parameter: a frequency [rad/s], or a factor [-].
    amplitude : (modes,) complex ndarray
        Amplitudes a_j [kg^1/2 m].
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
class ResponseCurve(CurveResult):
    """Hold steady states against a parameter, one branch after the other.

    Attributes
    ----------
    motion : SteadyMotion
        Motion of all DOFs at the points of the curve, then at `special`, then at the lowest and
        the highest amplitudes of `cycles`. The latter have no force, because its phase is not
        known.
    vary : str
        Parameter, as given to `rom.response_curve`.
    parameter : (n,) ndarray
        Values of the parameter: a frequency [rad/s], or a factor on forces or limits [-].
    amplitude : (n, modes) complex ndarray
        Amplitudes a_j [kg^1/2 m].
    error : (n, modes) ndarray
        Error of a_j at a constant parameter [kg^1/2 m], due to the friction table or to the steps
        of the contact problem.
    growth : (n,) ndarray
        Largest growth rate of small deviations [1/s]. It is interpolated between folds or Hopf
        points that are closer than the error and therefore omitted.
    branch : (n,) ndarray of int
        Number of the branch. Points of a branch are in their order along the curve.
    special : tuple of SpecialPoint
        Folds and Hopf points.
    cycles : SlowCycles
        Ranges of amplitudes that oscillate in slow time, beyond Hopf points.
    cut_off : (n,) ndarray
        Values of the parameter [rad/s] or [-] where a branch ends because of too many points, or
        because the contact problem does not converge.
    method : (n,) ndarray of str
        Friction at each point: "table", or "direct" for the contact problem itself.
    """

    vary: str
    parameter: Floats
    amplitude: Complexes
    error: Floats
    growth: Floats
    branch: NDArray[np.intp]
    special: tuple[SpecialPoint, ...]
    cycles: SlowCycles
    cut_off: Floats
    method: NDArray[np.str_]

    @property
    def stable(self) -> Flags:
        """Whether small deviations from each steady state decay, (n,) ndarray of bool."""
        return np.asarray(self.growth < 0.0)

    def at(self, value: float) -> tuple[Complexes, Flags]:
        """Return the steady states at a value of the parameter.

        Amplitudes are interpolated linearly between points of the curve, with errors of about
        1e-4.

        Parameters
        ----------
        value : float
            Value of the parameter [rad/s] or [-].

        Returns
        -------
        amplitude : (found, modes) complex ndarray
            Amplitudes a_j [kg^1/2 m]; several rows where branches coexist.
        stable : (found,) ndarray of bool
            Whether small deviations decay.
        """
        p, above = self.parameter, self.parameter > value
        same = self.branch[:-1] == self.branch[1:]
        (before,) = np.nonzero((above[:-1] != above[1:]) & same)
        part = ((value - p[before]) / (p[before + 1] - p[before]))[:, np.newaxis]
        a = (1.0 - part) * self.amplitude[before] + part * self.amplitude[before + 1]
        beside = np.append(above[1:] & same, False) | np.append(False, above[:-1] & same)
        (last,) = np.nonzero((p == value) & ~beside)  # the curve ends or turns back there
        nearest = np.append(np.where(part[:, 0] < 0.5, before, before + 1), last)
        return np.concatenate((a, self.amplitude[last])), self.stable[nearest]

    def _in_shape(self, sizes: Floats) -> Floats:
        return sizes[: self.parameter.size]

    def error_of(self, size: Floats) -> Floats:
        """Return the error of amplitudes that have the relative error of a_j.

        Parameters
        ----------
        size : (n, modes) ndarray
            Amplitudes at the points of the curve, in any unit.

        Returns
        -------
        (n, modes) ndarray
            Errors, in the unit of `size`.
        """
        modulus = np.abs(self.amplitude)
        return size * np.divide(self.error, modulus, out=np.zeros_like(size), where=modulus > 0.0)

    def sizes(self, shown: Shown) -> CurveSizes:
        """Return the amplitudes that a plot of the curve shows.

        Parameters
        ----------
        shown : Shown
            |a_j|, or displacement amplitudes of a DOF in given units.

        Returns
        -------
        CurveSizes
            Amplitudes at the points, at folds and Hopf points, and of slow limit cycles.
        """
        counts = self.parameter.size, len(self.special), self.cycles.parameter.size
        return CurveSizes(*np.split(shown.size(self.motion), np.cumsum(counts)))

    @property
    def _is_frequency(self) -> bool:
        return self.vary.startswith("frequency_")

    def in_units(self, parameter: ArrayLike, units: Units) -> Floats:
        """Return values of the parameter in the units of plots and tables.

        Parameters
        ----------
        parameter : array_like
            Values of the parameter [rad/s] or [-].
        units : Units
            Units of frequencies and displacements.

        Returns
        -------
        ndarray
            Values in these units.
        """
        return units.of_frequency(parameter) if self._is_frequency else np.asarray(parameter)

    def label(self, units: Units) -> str:
        """Return the name of the parameter with its unit.

        Parameters
        ----------
        units : Units
            Units of frequencies and displacements.

        Returns
        -------
        str
            Label of an axis, for instance "frequency A [Hz]".
        """
        unit = units.frequency if self._is_frequency else "-"
        return f"{self.vary.replace('_', ' ')} [{unit}]"

    def plot(self, ax: Axes | None = None, dof: int | None = None, units: Units = SI) -> Axes:
        """Plot amplitudes against the parameter, with errors, stability, folds and Hopf points.

        Stable states are solid, unstable states dashed; folds are circles and Hopf points squares.
        Bands show the error. Bars show the range of amplitudes that oscillate in slow time.

        Parameters
        ----------
        ax : Axes, optional
            Matplotlib axes. Default: the current axes.
        dof : int, optional
            DOF whose displacement amplitude is plotted. Default: |a_j|.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        Axes
            Axes of the plot.
        """
        ax, shown = axes_or_current(ax), Shown(dof, units)
        x, sizes = self.in_units(self.parameter, units), self.sizes(shown)
        error = self.error_of(sizes.points)
        for j in range(self.amplitude.shape[1]):
            size, color = sizes.points[:, j], f"C{j}"
            for number in np.unique(self.branch):
                own = self.branch == number
                plot_band(ax, x[own], size[own], error[own, j], color=color)
                for which, style in ((self.stable, "-"), (~self.stable, "--")):
                    ax.plot(x[own], np.where(which, size, np.nan)[own], style, color=color)
            where = self.in_units(self.cycles.parameter, units)
            low, high = sizes.lowest[:, j], sizes.highest[:, j]
            ax.vlines(where, low, high, color=color, alpha=0.3, lw=3)
            top = int(np.argmax(size))
            label_point(ax, f"|{'AB'[j]}|", (x[top], size[top]), color, 4.0)
            for point, height in zip(self.special, sizes.special[:, j], strict=True):
                marker = _MARKERS[point.kind]
                ax.plot(self.in_units(point.parameter, units), height, marker, color=color)
        ax.set(xlabel=self.label(units), ylabel=shown.named("amplitude"), ylim=(0.0, None))
        ax.margins(y=0.1)
        for kind in sorted({point.kind for point in self.special}):
            ax.plot([], [], _MARKERS[kind], color="0.4", label=f"{kind} point")
        if not self.stable.all():
            ax.plot([], [], "--", color="0.4", label="unstable")
        if ax.get_legend_handles_labels()[0]:
            ax.legend()
        return ax

    def _values(self, units: Units) -> dict[str, Any]:
        name = units.named(self.vary) if self._is_frequency else self.vary
        found: dict[str, Any] = {name: self.in_units(self.parameter, units), "branch": self.branch}
        for mode, a, error in zip("AB", self.amplitude.T, self.error.T, strict=False):
            found |= {f"{mode}_re": a.real, f"{mode}_im": a.imag, f"{mode}_error": error}
        return found | {"growth": self.growth}

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        found: dict[str, Floats] = {}
        sizes = self.size(Shown(dof, units))
        for mode, size, error in zip("AB", sizes.T, self.error_of(sizes).T, strict=False):
            found |= {mode: size, f"{mode} error": error}
        return found

    def to_dataframe(self, dof: int | None = None, units: Units = SI) -> Any:
        """Return the curve as a pandas DataFrame, with its `columns`, "stable" and "method".

        Parameters
        ----------
        dof : int, optional
            DOF whose displacement amplitude is added, with its error.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        DataFrame
            Table with one row for each steady state.
        """
        return super().to_dataframe(dof, units).assign(stable=self.stable, method=self.method)


@overload
def response_curve(
    model: Model,
    frequency: ArrayLike,
    force: Forces,
    vary: Varied,
    span: Sequence[ArrayLike],
    phase: ArrayLike = 0.0,
    largest_step: float = LARGEST_STEP,
    method: Method | None = None,
) -> ResponseCurve: ...
@overload
def response_curve(
    model: ToneModel,
    frequency: ArrayLike,
    force: Sequence[ToneForce],
    vary: Varied,
    span: Sequence[ArrayLike],
    phase: ArrayLike = 0.0,
    largest_step: float = LARGEST_STEP,
    method: None = None,
) -> ToneCurve: ...
def response_curve(
    model: Model | ToneModel,
    frequency: ArrayLike,
    force: Any,  # of either model
    vary: Varied,
    span: Sequence[ArrayLike],
    phase: ArrayLike = 0.0,
    largest_step: float = LARGEST_STEP,
    method: Method | None = None,
) -> ResponseCurve | ToneCurve:
    """Return all steady states in the friction table against a parameter, with their stability.

    The curve is followed through folds. Steady states are searched from many amplitudes and phases
    at nine values of the parameter, which also finds branches that no sweep reaches. A branch
    between two of these values may be missing.

    Parameters
    ----------
    model : Model or ToneModel
        Model with one or two modes. Of modes that share a tone the curve is that of
        `rom.tone_curve`, against "frequency_A", and on two tones also against "frequency_B".
    frequency : (modes,) array_like
        Forcing frequencies [rad/s]; a varied frequency is ignored. (tones,) if modes share a tone.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N]; one per tone if modes share a tone.
    vary : str
        Parameter of the curve:

        - "frequency_A" or "frequency_B": one forcing frequency [rad/s];
        - "frequency": both, on the line between two points (modes,), with a parameter from 0 to 1;
        - "force_A", "force_B", "force": a factor on the forces [-];
        - "limit": a factor on friction limits and preloads [-].
    span : pair
        First and last value of the parameter; for "frequency" two points (modes,) [rad/s].
    phase : float or (modes,) array_like, default 0.0
        Phases of the forces [rad].
    largest_step : float, default 0.02
        Largest distance of neighbouring points, relative to the span and the range of the table
        [-], 1e-4 to 0.1. Points are closer where the curve bends.
    method : {"table", "direct"}, optional
        "table": friction of the table, with its stated error. "direct": the contact problem at
        each forcing frequency, which takes seconds to minutes. Default: the table, and the contact
        problem if the table misses friction by more than the allowed error.

    Returns
    -------
    ResponseCurve or ToneCurve
        Steady states, folds and Hopf points. A branch ends where an amplitude leaves the table, or
        after 5000 points on a side (`ResponseCurve.cut_off`). `ToneCurve` if modes share a tone.

    Raises
    ------
    SlipmodeError
        If no steady state is found, an argument is outside its range, or the slow flow cannot
        follow a frequency. If `method` is "direct" and the model has no contact problem.

    Warns
    -----
    ValidityWarning
        If friction or a force violates an assumption of the method, the error of the friction
        table is above the allowed one, or a branch has too many points.

    Notes
    -----
    See "Response curves" in docs/theory.md.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(12.0,))
    >>> curve = rom.response_curve(model, [1.0], [{0: 0.15}], "frequency_A", (0.9, 1.1))
    >>> a, stable = curve.at(0.98)
    """
    if method not in (None, *get_args(Method)):
        raise SlipmodeError(f'method: must be "table", "direct" or None, got {method!r}')
    if not 1e-4 <= as_floats("largest_step", largest_step) <= 0.1:
        raise SlipmodeError(f"largest_step: must be 1e-4 to 0.1, got {largest_step}")
    if isinstance(model, ToneModel):
        if method is not None:
            raise SlipmodeError("method: must be left out for modes that share a tone")
        return curve_of_tone(model, frequency, force, vary, span, phase)
    problem = ForcedSlowFlow.of(model, frequency, force, phase, vary, span, largest_step)
    found = Branches.by_method(problem, method)
    branches, points, error = found.branches, found.points, found.error
    part, amplitude = points.z[:, -1], problem.amplitude(points.z)
    flow, forced = problem.at(part), (problem.ends.force != 0.0).any(axis=0)
    scale = flow.inputs["limit_scale"][:, np.newaxis]
    warn(friction_findings(model.reduced, model.law, (np.abs(amplitude) / scale).max(axis=0)))
    warn(forcing_findings(model.reduced, problem.ends.frequency, forced))
    ends = problem.parameter(np.array(cut_off(branches)))
    if ends.size:
        where = f"{vary} = {', '.join(f'{value:.6g}' for value in ends)}"
        reason = f"a branch has more than {MOST_POINTS} points. A shorter span shows more of it"
        if found.contact is not None:
            reason = "the contact problem does not converge. Compare with rom.steady_state"
        warn([Finding("curve", f"is incomplete beyond {where}", reason, "warning")])
    specials, smaller = significant_specials(problem, branches, error, found.contact)
    at = np.array([z for _, z in specials]).reshape(-1, points.z.shape[1])
    places = zip(specials, problem.parameter(at[:, -1]), problem.amplitude(at), strict=True)
    special = tuple(SpecialPoint(kind, float(value), a) for (kind, _), value, a in places)
    cycles = slow_cycles(problem, Points(points.rows[~smaller], points.unknowns))
    growth = points.eigenvalues[:, 0].real
    if smaller.any():
        every = np.arange(growth.size)
        growth = np.where(smaller, np.interp(every, every[~smaller], growth[~smaller]), growth)
    motion = _motion(found, np.vstack((points.z, at)), cycles)
    values = problem.parameter(part), amplitude, error.amplitude, growth, found.number
    by = methods(np.full(part.shape, found.contact is not None))
    return ResponseCurve(motion, vary, *values, special, cycles, ends, by)


def _motion(found: Branches, z: Floats, cycles: SlowCycles) -> SteadyMotion:
    """Return steady states z, then the ends of cycles, whose force is not known."""
    problem, contact = found.problem, found.contact
    at_cycles = np.tile(problem.part(cycles.parameter), 2)
    flow = problem.at(np.append(z[:, -1], at_cycles))
    flow.inputs["force"][len(z) :] = 0.0
    amplitude = np.concatenate([problem.amplitude(z), cycles.lowest, cycles.highest])
    motion = SteadyMotion.of(flow, amplitude, problem.applied)
    if contact is None:
        return motion
    friction, response = contact.solutions(z)
    at_rest = np.zeros((at_cycles.size, response.shape[1]), dtype=complex)
    every = ContactSolutions(friction, np.concatenate((response, at_rest)))
    return replace(motion, contact=every)
