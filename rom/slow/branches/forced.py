"""The forced slow flow by what is varied, in scaled unknowns, and all its steady states there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.reduction.force_response import Forces, off_resonance_shift
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.slow_flow import balance, inputs_of, rate_and_jacobian, rates, shifted_flow
from slipmode.rom.slow.steady import excitation_of
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers

Varied = Literal["frequency_A", "frequency_B", "frequency", "force_A", "force_B", "force", "limit"]

_STEP = 1e-6  # of the span, for derivatives by the parameter
_MODULI, _PHASES = (0.03, 0.2, 0.45, 0.75), 6  # of the amplitudes that searches start from
_PASSES = 30
_LONGEST_UPDATE = 0.3  # of these searches
_SETTLED = 1e-9
SAME = 1e-6  # distance of solutions that are one, scaled


@dataclass(frozen=True, eq=False)
class ForcedSlowFlow:
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
        force: Forces,
        phase: Sequence[float],
        vary: Varied,
        span: Sequence[ArrayLike],
    ) -> ForcedSlowFlow:
        """Of arguments as `response_curve` has them, which it refuses where they do not fit."""
        excitation = excitation_of(model, force, phase)
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
        _, first = np.unique(np.round(settled / SAME), axis=0, return_index=True)
        return np.column_stack((settled[np.sort(first)], np.full(first.size, part)))

    def held_at(self, part: Floats) -> Callable[[Floats], Floats]:
        """Rates with a'' too, (points, k) at y (points, k); NaN outside the friction table.

        As steady states have them where there are combination resonances, which turn meanwhile.
        """
        frequency, excitation = self.inputs(part)
        inputs = inputs_of(excitation, frequency)

        def rates_of(y: Floats) -> Floats:
            a = np.ascontiguousarray(y * self.scale).view(complex)
            moving = balance(self.flow, inputs, a).rate
            if not self.model.combinations:
                inside = np.isfinite(moving).all(axis=1)
                moving[inside] = rates(self.flow, inputs[inside], a[inside])
            return np.asarray(np.ascontiguousarray(moving).view(float) / self.scale)

        return rates_of

    def _at(self, y: Floats, part: Floats) -> tuple[Floats, Floats]:
        """Rates (points, k) and their Jacobians by y."""
        frequency, excitation = self.inputs(part)
        a = np.ascontiguousarray(y * self.scale).view(complex)
        F, J = rate_and_jacobian(self.flow, inputs_of(excitation, frequency), a)
        return F / self.scale, J * (self.scale / self.scale[:, np.newaxis])
