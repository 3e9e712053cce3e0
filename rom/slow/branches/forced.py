"""The forced slow flow by what is varied, in scaled unknowns, and all its steady states there."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.reduction.coupling import coupling_factor
from slipmode.rom.reduction.force_response import AppliedForces, Forces, phasor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.answer_error import TableError
from slipmode.rom.slow.slow_flow import (
    balance,
    inputs_of,
    rate_and_jacobian,
    rates,
    shifted_flow,
)
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers_along

Varied = Literal["frequency_A", "frequency_B", "frequency", "force_A", "force_B", "force", "limit"]

LARGEST_STEP = 0.02  # of span and table, between two points
_DIFFERENCE = 1e-6  # of the span: for derivatives, far above rounding
_NAMES = get_args(Varied)
_VARIED = "force", "frequency", "limit_scale"


@dataclass(frozen=True, eq=False)
class ForcedSlowFlow:
    """da/dt of the slow flow in scaled unknowns z = (Re a, Im a, ... / range, part of the span).

    Where limits are varied the unknowns are amplitudes over the factor.

    Attributes
    ----------
    inputs : (2,) ndarray of kernel.INPUTS
        At the ends of the span.
    is_reversed : bool
        Whether the span was given from the larger value to the smaller one. Curves are computed
        from the smaller value on, so that they do not depend on it.
    curve : kernel.Curve
        Its steady states.
    """

    model: Model
    applied: AppliedForces
    flow: kernel.SlowFlow
    span: tuple[float, float]
    inputs: NDArray[np.void]
    is_reversed: bool
    curve: kernel.Curve

    __repr__ = short_repr

    @classmethod
    def of(
        cls,
        model: Model,
        frequency: ArrayLike,
        force: Forces,
        phase: ArrayLike,
        vary: Varied,
        span: Sequence[ArrayLike],
        largest_step: float = LARGEST_STEP,
    ) -> ForcedSlowFlow:
        """Of arguments as `response_curve` has them, which it refuses where they do not fit."""
        applied = AppliedForces.of(model.reduced, force)
        excitation = applied.excitation(phase)
        allowed = [name for name in _NAMES if model.modes == 2 or name[-2:] != "_B"]
        if vary not in allowed:
            raise SlipmodeError(f"vary: must be one of {', '.join(allowed)}, got {vary!r}")
        ends = [as_floats("span", end) for end in (span if np.iterable(span) else ())]
        both = vary == "frequency"
        shape = (model.modes,) if both else ()
        fits = len(ends) == 2 and all(end.shape == shape for end in ends)
        if not fits or not np.isfinite(values := np.array(ends)).all():
            of_what = f"points of {model.modes} frequencies" if both else "numbers"
            raise SlipmodeError(f"span: must be two finite {of_what}, got {span}")
        if np.all(values[0] == values[1]) or (not vary.startswith("freq") and values.min() < 0.0):
            raise SlipmodeError(f"span: must be two different values, factors >= 0, got {span}")
        if vary == "limit" and (
            values.min() == 0.0 or not is_homogeneous(model.law, model.reduced.n_contacts)
        ):
            raise SlipmodeError(
                "vary: limits vary with factors > 0, and of laws that scale with them: not of "
                f"tanh, nor across a gap; got {model.law!r}, span {span}"
            )
        Omega = as_floats("frequency", frequency)
        if Omega.shape != (model.modes,):
            raise SlipmodeError(f"frequency: must be {model.modes} numbers [rad/s], got {Omega}")
        is_reversed = values[0].tolist() > values[1].tolist()
        values = values[::-1] if is_reversed else values
        inputs = np.repeat(inputs_of(excitation[np.newaxis], Omega), 2)
        mode = "AB".find(vary[-1])
        if both:
            inputs["frequency"][:, : model.modes] = values
        elif vary.startswith("frequency"):
            inputs["frequency"][:, mode] = values
        elif mode >= 0:
            inputs["force"][:, mode] *= values
        elif vary == "force":
            inputs["force"] *= values[:, np.newaxis]
        else:
            inputs["limit_scale"] = values
        carriers = inputs["frequency"][:, : model.modes]
        check_carriers_along(model.reduced, carriers, excitation != 0.0)
        flow = shifted_flow(model, applied.shift)
        forced = kernel.Forced(flow=ctypes.addressof(flow), inputs=inputs.ctypes.data)
        forced.scale[: model.modes] = model.table.amplitude_range
        forced.owned = flow, inputs
        curve = kernel.Curve()
        kernel.check(
            kernel.lib.sm_forced_curve(forced, largest_step, ctypes.byref(curve)), "curve"
        )
        curve.owned = forced
        first, last = values.tolist() if not both else (1.0, 0.0) if is_reversed else (0.0, 1.0)
        return cls(model, applied, flow, (first, last), inputs, is_reversed, curve)

    @property
    def scale(self) -> Floats:
        """Of the unknowns, (2 modes,)."""
        return np.repeat(self.model.table.amplitude_range, 2)

    def parameter(self, part: Floats) -> Floats:
        """The value of what is varied, at parts of the span."""
        return np.asarray(self.span[0] + part * (self.span[1] - self.span[0]))

    def part(self, parameter: Floats) -> Floats:
        """Return the parts of the span that values of what is varied are."""
        return np.asarray((parameter - self.span[0]) / (self.span[1] - self.span[0]))

    def limit_scale(self, part: Floats) -> Floats:
        """Friction limits at parts of the span, over those of the model."""
        first, last = self.inputs["limit_scale"]
        return np.asarray(first + part * (last - first))

    def amplitude(self, z: Floats) -> Complexes:
        """a_j (points, modes) of solutions (points, k + 1)."""
        size = self.limit_scale(z[:, -1])[:, np.newaxis] * self.scale
        return np.asarray((z[:, :-1] * size).view(complex))

    def solutions(self, sections: int) -> Floats:
        """Steady states at both ends of the span and parts of it between, (found, k + 1)."""
        z = np.empty((sections * kernel.FORCED_CELLS, self.curve.unknowns + 1))
        found = ctypes.c_size_t()
        status = kernel.lib.sm_forced_search(self.curve.owned, sections, z.ctypes.data, found)
        kernel.check(status, "amplitude: slow flow")
        return z[: found.value]

    def held_at(self, part: Floats) -> Callable[[Floats], Floats]:
        """Rates with a'' too, (points, k) at y (points, k); NaN outside the friction table.

        As steady states have them where there are combination resonances, which turn meanwhile.
        """
        inputs = self.inputs_at(part)
        size = np.multiply.outer(inputs["limit_scale"], self.scale)

        def rates_of(y: Floats) -> Floats:
            found = np.full_like(y, np.nan)
            (at,) = np.nonzero(np.isfinite(y).all(axis=1))
            a = np.ascontiguousarray(y[at] * size[at]).view(complex)
            moving = balance(self.flow, inputs[at], a).rate
            if not self.model.combinations:
                inside = np.isfinite(moving).all(axis=1)
                moving[inside] = rates(self.flow, inputs[at][inside], a[inside])
            found[at] = np.ascontiguousarray(moving).view(float) / size[at]
            return found

        return rates_of

    def linearised(self, z: Floats) -> Floats:
        """Return the derivatives of the scaled rates by z, (points, k, k + 1), at solutions.

        NaN at the end of the friction table.
        """
        part, unknowns = z[:, -1], self.curve.unknowns
        size = np.multiply.outer(self.limit_scale(part), self.scale)
        _, jacobian = rate_and_jacobian(self.flow, self.inputs_at(part), self.amplitude(z))
        found = np.empty((len(z), unknowns, unknowns + 1))
        found[:, :, :-1] = jacobian * size[:, np.newaxis] / size[:, :, np.newaxis]
        sides = [z + sign * _DIFFERENCE * np.eye(unknowns + 1)[-1] for sign in (1.0, -1.0)]
        above, below = (self._scaled_rates(side) for side in sides)
        found[:, :, -1] = (above - below) / (2.0 * _DIFFERENCE)
        return found

    def _scaled_rates(self, z: Floats) -> Floats:
        size = np.multiply.outer(self.limit_scale(z[:, -1]), self.scale)
        rate = balance(self.flow, self.inputs_at(z[:, -1]), self.amplitude(z)).rate
        return np.ascontiguousarray(rate).view(float) / size

    def table_error(self, z: Floats, weight: Floats | None) -> TableError:
        """Return the error of S_j at solutions, see `TableError.of`."""
        limit_scale = self.limit_scale(z[:, -1])
        effective = np.abs(self._effective(z)) / limit_scale[:, np.newaxis]
        frequency = self.inputs_at(z[:, -1])["frequency"][:, : self.model.modes]
        return TableError.of(self.model, effective, frequency, limit_scale, weight)

    def rate_change(self, z: Floats, friction: Complexes | Floats) -> Complexes:
        """Return the change of da/dt (points, modes) by one of S_j (points, modes)."""
        inputs = self.inputs_at(z[:, -1])
        factor = coupling_factor(self.model.reduced, inputs["frequency"][:, : self.model.modes])
        mass = balance(self.flow, inputs, self.amplitude(z)).mass
        turned = np.exp(1j * np.angle(self._effective(z)))
        return np.asarray(factor * turned * friction / mass)

    def neglected_force(self, z: Floats) -> Floats:
        """Return |da/dt| (points, modes) by the neglected force through dampers."""
        inputs = self.inputs_at(z[:, -1])
        mass = balance(self.flow, inputs, self.amplitude(z)).mass
        force = inputs["force"][:, : self.model.modes] * self.applied.through_dampers
        return np.asarray(np.abs(0.5 * force / mass))

    def _effective(self, z: Floats) -> Complexes:
        """Amplitudes (points, modes) at which the friction table is looked up."""
        inputs, modes = self.inputs_at(z[:, -1]), slice(0, self.model.modes)
        factor = coupling_factor(self.model.reduced, inputs["frequency"][:, modes])
        force = phasor(inputs["force"], inputs["phase"])[:, modes]
        return np.asarray(factor * (self.amplitude(z) + self.applied.shift * force))

    def inputs_at(self, part: Floats) -> NDArray[np.void]:
        """Return the inputs at parts of the span (points,), of which they are linear functions."""
        first, last = self.inputs
        at = np.repeat(self.inputs[:1], part.size)
        for name in _VARIED:
            at[name] = first[name] + np.multiply.outer(part, last[name] - first[name])
        return at
