"""The forced slow flow with a varied parameter, in scaled unknowns, and its steady states."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers_along

Varied = Literal["frequency_A", "frequency_B", "frequency", "force_A", "force_B", "force", "limit"]

_MOST_FOUND = 1024  # steady states at a value of the parameter: one in each cell of the search
LARGEST_STEP = 0.02  # between two points, relative to the span and to the table's range


@frozen
class ForcedSlowFlow:
    """da/dt of the slow flow in scaled unknowns z = (Re a, Im a, ... / range, part of the span).

    Where limits are varied, the unknowns are amplitudes divided by the factor.
    """

    applied: AppliedForces
    ends: ForcedFlow  # At the two ends of the span
    span: tuple[float, float]
    # Whether the span was given from the larger value to the smaller one. Curves are computed from
    # the smaller value on, so that they do not depend on it.
    is_reversed: bool
    curve: kernel.Structure  # Its steady states

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
        """Return the flow for arguments of `response_curve`; refuse those that do not fit."""
        applied = AppliedForces.of(model.reduced, force)
        excitation = applied.excitation(phase)
        reduced, tones = model.reduced, model.reduced.tones
        allowed = [name for name in get_args(Varied) if tones == 2 or name[-2:] != "_B"]
        if vary not in allowed:
            raise SlipmodeError(f"vary: must be one of {', '.join(allowed)}, got {vary!r}")
        given = [as_floats("span", end) for end in (span if np.iterable(span) else ())]
        both = vary == "frequency"
        shape = (tones,) if both else ()
        fits = len(given) == 2 and all(end.shape == shape for end in given)
        if not fits or not np.isfinite(values := np.array(given)).all():
            of_what = f"points of {tones} frequencies" if both else "numbers"
            raise SlipmodeError(f"span: must be two finite {of_what}, got {span}")
        if np.all(values[0] == values[1]) or (not vary.startswith("freq") and values.min() < 0.0):
            raise SlipmodeError(f"span: must be two different values, factors >= 0, got {span}")
        if vary == "limit" and (
            values.min() == 0.0 or not is_homogeneous(model.law, reduced.n_contacts)
        ):
            raise SlipmodeError(
                "vary: a limit needs factors > 0 and a law whose motion scales with its limits, "
                f"which excludes tanh and gaps; got {model.law!r}, span {span}"
            )
        Omega = as_floats("frequency", frequency)
        if Omega.shape != (tones,):
            raise SlipmodeError(f"frequency: must be {tones} numbers [rad/s], got {Omega}")
        is_reversed = values[0].tolist() > values[1].tolist()
        values = values[::-1] if is_reversed else values
        name, _, mode = vary.partition("_")
        varied, along = ["AB".index(mode)] if mode else list(range(tones)), np.tile(Omega, (2, 1))
        if name == "frequency":
            along[:, varied] = values.reshape(2, -1)
        ends = ForcedFlow.of(model, reduced.carriers(along), excitation, applied.shift)
        inputs = ends.inputs
        if name == "limit":
            inputs["limit_scale"] = values
        elif name == "force":
            inputs["force"][:, varied] *= values[:, np.newaxis]
        check_carriers_along(reduced, ends.frequency, excitation != 0.0)
        forced = kernel.Forced(flow=ends.flow, inputs=inputs)
        forced.scale[: model.modes] = model.table.amplitude_range
        curve = kernel.Curve()
        status = kernel.lib.sm_forced_curve(forced, largest_step, curve)
        kernel.check(status, "curve")
        curve.owned["forced"] = forced
        first, last = values.tolist() if not both else (1.0, 0.0) if is_reversed else (0.0, 1.0)
        return cls(applied, ends, (first, last), is_reversed, curve)

    @property
    def model(self) -> Model:
        """The model whose table the curve is followed in."""
        return self.ends.model

    @property
    def scale(self) -> Floats:
        """Amplitudes by which the unknowns (2 modes,) are divided [kg^1/2 m]."""
        return np.repeat(self.model.table.amplitude_range, 2)

    def parameter(self, part: Floats) -> Floats:
        """Return values of the parameter at parts of the span."""
        return np.asarray(self.span[0] + part * (self.span[1] - self.span[0]))

    def part(self, parameter: Floats) -> Floats:
        """Return the parts of the span at values of the parameter."""
        return np.asarray((parameter - self.span[0]) / (self.span[1] - self.span[0]))

    def at(self, part: Floats) -> ForcedFlow:
        """Return the flow at parts of the span (points,), of which its inputs are linear."""
        first, last = self.ends.inputs
        inputs = np.repeat(self.ends.inputs[:1], part.size)
        for name in ("force", "frequency", "limit_scale"):
            inputs[name] = first[name] + np.multiply.outer(part, last[name] - first[name])
        return self.ends.with_inputs(inputs)

    def size(self, part: Floats) -> Floats:
        """Return the amplitudes (points, 2 modes) whose unknowns are 1 at parts of the span."""
        return np.asarray(np.multiply.outer(self.at(part).inputs["limit_scale"], self.scale))

    def amplitude(self, z: Floats) -> Complexes:
        """Return a_j (points, modes) of solutions (points, k + 1)."""
        return np.asarray((z[:, :-1] * self.size(z[:, -1])).view(complex))

    def solutions(self, sections: int) -> Floats:
        """Return steady states at both ends of the span and at parts between, (found, k + 1)."""
        z, found = np.empty((sections * _MOST_FOUND, self.curve.unknowns + 1)), ctypes.c_size_t()
        status = kernel.lib.sm_forced_solutions(
            self.curve.owned["forced"], sections, len(z), z, ctypes.byref(found)
        )
        kernel.check(status, "curve")
        return z[: found.value].copy()
