"""Response curves: all steady states against a frequency, a force or the friction limit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.reduction.force_response import Forces, off_resonance_shift
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.branches.continuation import Branch, Kind, branch_through
from slipmode.rom.slow.slow_flow import inputs_of, rate_and_jacobian, shifted_flow
from slipmode.rom.slow.steady import excitation_of
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers, motion_findings, warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Varied = Literal["frequency_A", "frequency_B", "frequency", "force_A", "force_B", "force", "limit"]

_STEP = 1e-6  # of the span, for derivatives by the parameter
_LARGEST_STEP = 0.02  # of span and table, between two points
_SECTIONS = 9  # values of the parameter at which steady states are searched
_MODULI, _PHASES = (0.03, 0.2, 0.45, 0.75), 6  # of the amplitudes that searches start from
_PASSES = 30
_LONGEST_UPDATE = 0.3  # of these searches
_SETTLED = 1e-9
_SAME = 1e-6  # distance of solutions that are one, scaled
_BEND = 0.05  # of the length of a chord: how far the branch may be from it


@dataclass(frozen=True, eq=False)
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

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class ResponseCurve:
    """Steady states against what is varied, branch after branch.

    Attributes
    ----------
    vary : str
    parameter : (n,) ndarray
        Its values: [rad/s], or relative to the forces and limits given [-].
    amplitude : (n, modes) complex ndarray
        a_j [kg^1/2 m].
    growth : (n,) ndarray
        Of the small deviation that grows fastest, or decays slowest [1/s].
    branch : (n,) ndarray of int
        Neighbours of one branch follow one another along the curve.
    special : tuple of SpecialPoint
    """

    vary: str
    parameter: Floats
    amplitude: Complexes
    growth: Floats
    branch: NDArray[np.intp]
    special: tuple[SpecialPoint, ...]

    __repr__ = short_repr

    @property
    def stable(self) -> Flags:
        """Whether motion near a steady state tends to it, (n,)."""
        return np.asarray(self.growth < 0.0)

    def at(self, value: float) -> tuple[Complexes, Flags]:
        """Steady states at a value of the parameter, (found, modes), and which are stable.

        Between the points of the curve: on straight lines, by which amplitudes are some 1e-4 off.
        """
        p = self.parameter
        across = (p[:-1] > value) != (p[1:] > value)
        (before,) = np.nonzero(across & (self.branch[:-1] == self.branch[1:]))
        part = ((value - p[before]) / (p[before + 1] - p[before]))[:, np.newaxis]
        a = (1.0 - part) * self.amplitude[before] + part * self.amplitude[before + 1]
        return a, self.stable[np.where(part[:, 0] < 0.5, before, before + 1)]

    def plot(self, ax: Axes | None = None) -> Axes:
        """|a_j| against the parameter: stable solid, unstable dashed; folds and Hopf points."""
        ax = extra("matplotlib.pyplot", "pictures").gca() if ax is None else ax
        for j in range(self.amplitude.shape[1]):
            size, color = np.abs(self.amplitude[:, j]), f"C{j}"
            for number in np.unique(self.branch):
                own = self.branch == number
                for shown, style in ((self.stable, "-"), (~self.stable, "--")):
                    part = np.where(shown, size, np.nan)[own]
                    ax.plot(self.parameter[own], part, style, color=color)
            ax.plot([], [], color=color, label=f"|{'AB'[j]}|")
            for kind, marker in (("fold", "o"), ("Hopf", "s")):
                at = [point for point in self.special if point.kind == kind]
                where = [point.parameter for point in at]
                ax.plot(where, [abs(point.amplitude[j]) for point in at], marker, color=color)
        unit = "[rad/s]" if self.vary.startswith("frequency_") else "[-]"
        ax.set(xlabel=f"{self.vary.replace('_', ' ')} {unit}", ylabel="amplitude [kg$^{1/2}$ m]")
        ax.legend()
        return ax

    def to_dataframe(self) -> Any:
        """One row per steady state."""
        columns: dict[str, object] = {self.vary: self.parameter, "branch": self.branch}
        for j in range(self.amplitude.shape[1]):
            name = "AB"[j]
            columns |= {f"{name}_re": self.amplitude[:, j].real}
            columns |= {f"{name}_im": self.amplitude[:, j].imag}
        return extra("pandas", "pandas").DataFrame(
            columns | {"growth": self.growth, "stable": self.stable}
        )


def response_curve(
    model: Model,
    frequency: ArrayLike,
    force: Forces,
    vary: Varied,
    span: Sequence[ArrayLike],
    phase: Sequence[float] = (0.0, 0.0),
) -> ResponseCurve:
    """Follow every steady state within the friction table, through folds, with its stability.

    Branches are searched from many amplitudes and phases at values all over the span, so also
    those that no sweep reaches; one that is narrower than the searches may be missed.

    Parameters
    ----------
    model : Model
        The nearer its carriers to the forcing, the more exact: up to 7 % off where a strong
        contact lifts off and the forcing is 3 % away.
    frequency : (modes,) array_like
        Forcing frequencies [rad/s]; what is varied is not looked at.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N] as in `steady`.
    vary : str
        "frequency_A" or "frequency_B": one of them [rad/s]; "frequency": both, along the line
        between two points (modes,), the parameter its part from 0 to 1; "force_A", "force_B",
        "force": a factor on the forces; "limit": a factor on friction limits and preloads.
    span : pair
        First and last value.
    phase : sequence of float
        Phases of the forces [rad].

    Returns
    -------
    ResponseCurve
        It ends where an amplitude leaves the table.

    Raises
    ------
    SlipmodeError
        If no steady state is found at all, or a frequency is none that the slow flow can follow.

    Warns
    -----
    ValidityWarning
        Where friction or the force strain what the method assumes.
    """
    problem = _Forced.of(model, frequency, excitation_of(model, force, phase), force, vary, span)
    branches: list[Branch] = []
    for p in np.linspace(0.0, 1.0, _SECTIONS):
        for z in problem.solutions(p):
            if any(_passes(branch, z) for branch in branches):
                continue
            branch = branch_through(problem.rates, z, _LARGEST_STEP)
            if branch is not None and len(branch.points) > 1:
                branches.append(branch)
    if not branches:
        raise SlipmodeError(
            f"span: no steady state inside the friction table, whose range is "
            f"{model.table.amplitude_range}, over the span {span}"
        )
    points = [(number, point) for number, b in enumerate(branches) for point in b.points]
    z = np.array([point.z for _, point in points])
    amplitude = np.array([problem.amplitude(row) for row in z])
    warn(motion_findings(model.reduced, model.law, force, np.abs(amplitude).max(axis=0)))
    special = [
        SpecialPoint(kind, float(problem.parameter(at.z[-1])), problem.amplitude(at.z))
        for branch in branches
        for kind, at in branch.special
    ]
    return ResponseCurve(
        vary,
        problem.parameter(z[:, -1]),
        amplitude,
        np.array([point.eigenvalues.real.max() for _, point in points]),
        np.array([number for number, _ in points]),
        tuple(special),
    )


@dataclass(frozen=True, eq=False)
class _Forced:
    """da/dt of the slow flow in scaled unknowns z = (Re a, Im a, ... / range, part of the span).

    `inputs` leaves frequencies and excitations (points, modes) at parts of the span (points,);
    with limits varied the unknowns are amplitudes over the factor.
    """

    model: Model
    flow: kernel.SlowFlow
    scale: Floats
    span: tuple[float, float]
    inputs: Callable[[Floats], tuple[Floats, Complexes]]
    scales_limits: bool

    __repr__ = short_repr

    @classmethod
    def of(
        cls,
        model: Model,
        frequency: ArrayLike,
        excitation: Complexes,
        force: Forces,
        vary: Varied,
        span: Sequence[ArrayLike],
    ) -> _Forced:
        if vary not in get_args(Varied) or (vary.endswith("_B") and model.modes == 1):
            allowed = [name for name in get_args(Varied) if model.modes == 2 or name[-2:] != "_B"]
            raise SlipmodeError(f"vary: must be one of {', '.join(allowed)}, got {vary!r}")
        ends = [np.asarray(end, dtype=float) for end in span]
        both = vary == "frequency"
        shape = (model.modes,) if both else ()
        if len(ends) != 2 or any(end.shape != shape or not np.isfinite(end).all() for end in ends):
            of_what = f"points of {model.modes} frequencies" if both else "numbers"
            raise SlipmodeError(f"span: must be two finite {of_what}, got {span}")
        first, last = ends
        if np.all(first == last) or (not vary.startswith("freq") and min(first, last) < 0.0):
            raise SlipmodeError(f"span: must be two different values, factors >= 0, got {span}")
        if vary == "limit" and (
            min(first, last) == 0.0 or not is_homogeneous(model.law, model.reduced.n_contacts)
        ):
            raise SlipmodeError(
                "vary: limits vary with factors > 0, and of laws that scale with them: not of "
                f"tanh, nor across a gap; got {model.law!r}, span {span}"
            )
        Omega = np.asarray(frequency, dtype=float)
        if Omega.shape != (model.modes,):
            raise SlipmodeError(f"frequency: must be {model.modes} numbers [rad/s], got {Omega}")
        mode = "AB".find(vary[-1])

        def inputs(part: Floats) -> tuple[Floats, Complexes]:
            value = first + np.multiply.outer(part, last - first)
            frequencies = np.tile(Omega, (part.size, 1))
            excitations = np.tile(excitation, (part.size, 1))
            if both:
                frequencies = value
            elif vary.startswith("frequency"):
                frequencies[:, mode] = value
            elif mode >= 0:
                excitations[:, mode] *= value
            elif vary == "force":
                excitations *= value[:, np.newaxis]
            else:
                excitations /= value[:, np.newaxis]
            return frequencies, excitations

        check_carriers(model.reduced, inputs(np.linspace(0, 1, 101))[0], excitation != 0.0)
        shift = off_resonance_shift(model.reduced, force)
        scale = np.repeat(model.table.amplitude_range, 2)
        limits = (0.0, 1.0) if both else (float(first), float(last))
        return cls(model, shifted_flow(model, shift), scale, limits, inputs, vary == "limit")

    def parameter(self, part: Floats | float) -> Floats:
        """The value of what is varied, at a part of the span."""
        return np.asarray(self.span[0] + np.asarray(part) * (self.span[1] - self.span[0]))

    def amplitude(self, z: Floats) -> Complexes:
        """a_j (modes,) of a solution."""
        factor = float(self.parameter(z[-1])) if self.scales_limits else 1.0
        a: Complexes = (z[:-1] * self.scale).view(complex)
        return factor * a

    def rates(self, z: Floats) -> tuple[Floats, Floats]:
        """F and its Jacobian, see continuation.Rates."""
        part = z[-1] + _STEP * np.array([-1.0, 0.0, 1.0])
        F, J = self._at(np.tile(z[:-1], (3, 1)), part)
        return F[1], np.column_stack((J[1], (F[2] - F[0]) / (2.0 * _STEP)))

    def solutions(self, part: float) -> Floats:
        """Steady states at a part of the span, (found, k + 1): Newton's method from everywhere."""
        modes = self.model.modes
        phase = np.exp(2j * np.pi * np.arange(_PHASES) / _PHASES)
        one = np.multiply.outer(_MODULI, phase).ravel()
        grid = np.stack(np.meshgrid(*[one] * modes, indexing="ij"), axis=-1).reshape(-1, modes)
        _, excitation = self.inputs(np.array([part]))
        grid = np.where(excitation == 0.0, 0.0, grid)  # an unforced mode is at rest
        y = np.unique(np.ascontiguousarray(grid), axis=0).view(float)
        for _ in range(_PASSES):
            F, J = self._at(y, np.full(len(y), part))
            inside = np.isfinite(F).all(axis=1)
            y, F, J = y[inside], F[inside], J[inside]
            regular = np.abs(np.linalg.det(J)) > 0.0
            y, F, J = y[regular], F[regular], J[regular]
            update = np.linalg.solve(J, F[..., np.newaxis])[..., 0]
            size = np.abs(update).max(axis=1, initial=0.0)
            y = y - update / np.maximum(1.0, size / _LONGEST_UPDATE)[:, np.newaxis]
            if size.max(initial=0.0) <= _SETTLED:
                break
        settled = y[size <= _SETTLED]
        _, first = np.unique(np.round(settled / _SAME), axis=0, return_index=True)
        return np.column_stack((settled[np.sort(first)], np.full(first.size, part)))

    def _at(self, y: Floats, part: Floats) -> tuple[Floats, Floats]:
        """Rates (points, k) and their Jacobians by y."""
        frequency, excitation = self.inputs(part)
        a = np.ascontiguousarray(y * self.scale).view(complex)
        F, J = rate_and_jacobian(self.flow, inputs_of(excitation, frequency), a)
        return F / self.scale, J * (self.scale / self.scale[:, np.newaxis])


def _passes(branch: Branch, z: Floats) -> bool:
    """Whether a branch goes through a solution: near a chord of it, which bends little."""
    points = np.array([point.z for point in branch.points])
    start, chord = points[:-1], np.diff(points, axis=0)
    length = np.linalg.norm(chord, axis=1)
    along = np.einsum("nk,nk->n", z - start, chord) / length**2
    nearest = start + np.clip(along, 0.0, 1.0)[:, np.newaxis] * chord
    return bool(np.any(np.linalg.norm(z - nearest, axis=1) <= _SAME + _BEND * length))
