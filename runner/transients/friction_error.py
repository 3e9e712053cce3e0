"""The error of a run by errors of friction beyond the tolerance of its table.

A table may miss its tolerance, and forcing may be far from the reference frequencies of the table.

The error belongs to a steady state at each time, by linearisation: see `rom.slow.answer_error`.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.reduced import coupling_factor
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.answer_error import curve_displacement
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.validity import Finding
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.transients.motion import scripted


class FrictionErrorRecord:
    """The RMS error of the amplitudes of a run due to friction errors beyond the tolerance."""

    def __init__(self, plan: ModesPlan, model: Model) -> None:
        self._plan, self._model = plan, model
        self._shift = AppliedForces.of(model.reduced, plan.excited.force_patterns).shift
        self._squares = np.zeros((2, model.modes))  # of errors, and of amplitudes

    def add(self, amplitude: Complexes, in_slow_time: Flags, first: int, stride: int) -> None:
        """Add amplitudes (steps, modes) at the starts of every `stride` steps from `first` on."""
        steps = slice(first, first + stride * len(amplitude), stride)
        error = self._error(amplitude, steps) * in_slow_time[:, np.newaxis]
        size = np.abs(amplitude)
        self._squares += (np.minimum(error, size) ** 2).sum(axis=0), (size**2).sum(axis=0)

    def _error(self, amplitude: Complexes, steps: slice) -> Floats:
        """Return the error of |a_j| (steps, modes); 0 outside the friction table."""
        plan, model = self._plan, self._model
        script = scripted(plan.excited, plan.schedule, steps)
        flow = ForcedFlow.of(model, script.frequency, script.force, self._shift)
        flow.inputs["limit_scale"] = script.scale
        scale = script.scale[:, np.newaxis]
        effective = np.minimum(
            np.abs(flow.effective(amplitude)) / scale, model.table.amplitude_range
        )
        distance = np.abs(script.frequency / model.reduced.carrier - 1.0).max(axis=1)
        stated = model.accuracy.total + model.detuning_error(distance)[:, np.newaxis]
        beyond = np.maximum(stated - model.accuracy.tolerance, 0.0) * model.error_scale(effective)
        factor, now = coupling_factor(model.reduced, script.frequency), flow.balance(amplitude)
        change = np.abs(factor * scale * beyond / now.mass)
        _, jacobian = flow.rate_and_jacobian(amplitude)
        return np.nan_to_num(curve_displacement(jacobian, change)[0])

    def findings(self) -> list[Finding]:
        """Return the events for the recording; empty if friction is within the tolerance.

        A table that misses its tolerance is a warning, and so is an error above the allowed one.
        """
        plan, model, (errors, sizes) = self._plan, self._model, self._squares
        error = np.sqrt(np.divide(errors, sizes, out=np.zeros_like(sizes), where=sizes > 0.0))
        each = zip(plan.excited.modes, error, strict=True)
        listed = ", ".join(f"|{mode}| {percentage(part)}" for mode, part in each)
        choice, allowed = (
            f"have an estimated RMS error of {listed}",
            plan.scene.model.transient_error,
        )
        reason = "due to friction errors beyond model.tolerance"
        is_small = bool(np.all(error <= allowed))
        found = model.accuracy.findings()
        if not is_small:
            reached = np.array(plan.schedule.frequency_range(plan.excited.modes))
            found += model.detuning_findings(reached)
            reason += f", above {percentage(allowed)}. Use a shorter frequency sweep, or compare "
            reason += "with slipmode validate"
            found.append(Finding("amplitudes", choice, reason, "warning"))
        elif error.any():
            found.append(Finding("amplitudes", choice, reason))
        return found
