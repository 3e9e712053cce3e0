"""The estimated errors of a run in slow time: of transients, and of friction.

Slow time has an error while amplitudes change, see `rom.slow.transient`. A table may miss its
tolerance, and forcing may be far from the reference frequencies of the table: the error by
friction belongs to a steady state at each time, by linearisation, see `rom.slow.answer_error`.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.detuning import coupling_factor
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import percentage, short_list
from slipmode.rom.slow.answer_error import curve_displacement
from slipmode.rom.slow.slow_flow import ForcedFlow, inputs_of, rates, slow_flow
from slipmode.rom.slow.transient import TransientError, said_error
from slipmode.rom.validity import Finding
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.transients import slow_time_error
from slipmode.runner.transients.motion import OutputColumns


class TransientErrors:
    """`TransientError` of a run relative to the amplitude range of its friction table.

    It keeps the largest error in slow time, and when it exceeds the allowed one.
    """

    def __init__(self, plan: ModesPlan, model: Model, columns: OutputColumns) -> None:
        self._plan, self._columns = plan, columns
        self._flow = slow_flow(model, plan.excited.force_patterns)
        self._estimate = TransientError.of(*plan.excited.contacts)
        self._shift = AppliedForces.of(model.reduced, plan.excited.force_patterns).shift
        # intervals fewer than ten cycles apart are reported as one
        self._gap = 20.0 * np.pi / plan.excited.reduced.carrier.min()
        self._largest = np.zeros(model.modes)
        self._above: list[tuple[float, float]] = []

    def at(
        self,
        amplitude: Complexes,
        angle: Floats,
        first: int,
        stride: int = 1,
        rate: Complexes | None = None,
    ) -> Floats:
        """Return the error at the starts of steps, (steps, modes); 1 outside the friction table.

        `stride` is the difference of the numbers of the steps. `rate` is da/dt, by default from
        the slow flow. All of them are (steps, modes).
        """
        steps = slice(first, first + stride * len(amplitude), stride)
        excited, schedule = self._plan.excited, self._plan.schedule
        force, frequency, scale = excited.step_loads(schedule, steps)
        if rate is None:
            rising = excited.load_rates(schedule, steps)
            inputs = inputs_of(force, frequency, rising.force, rising.frequency, angle)
            inputs["limit_scale"], inputs["limit_scale_rate"] = scale[:, 0], rising.scale[:, 0]
            try:
                rate = rates(self._flow, inputs, amplitude)
            except SlipmodeError:
                return np.ones(amplitude.shape)
        acting = (amplitude + self._shift * force) / scale
        error = self._estimate.at(rate / scale, frequency, acting)
        return np.asarray(error / np.array(self._plan.amplitude))

    def add(self, rows: Floats, counted: Flags, first: int, stride: int) -> None:
        """Add outputs at the starts of every `stride` steps from `first` on, if they count."""
        amplitude, angle = self._columns.amplitudes(rows), rows[:, self._columns.angle]
        error = self.at(amplitude, angle, first, stride) * counted[:, np.newaxis]
        self._largest = np.maximum(self._largest, error.max(axis=0, initial=0.0))
        time = self._plan.schedule.time(slice(first, first + stride * len(rows) + 1))
        ends = np.append(time[:-1:stride], time[-1])
        allowed = self._plan.scene.model.transient_error
        for k in np.flatnonzero(np.any(error > allowed, axis=1)):
            start, end = float(ends[k]), float(ends[k + 1])
            if self._above and start - self._above[-1][1] <= self._gap:
                start = self._above.pop()[0]
            self._above.append((start, end))

    def finding(self) -> Finding:
        """Return the event for the recording: a warning if the error exceeds the allowed one."""
        largest = said_error(self._plan.excited.modes, self._largest)
        if not self._above:
            return Finding("transients", "slow time", largest)
        listed = short_list(f"{a:g} to {b:g} s" for a, b in self._above)
        return slow_time_error(self._plan.scene, f"{largest} from {listed}")


class FrictionErrors:
    """The RMS error of the amplitudes of a run due to friction errors beyond the tolerance."""

    def __init__(self, plan: ModesPlan, model: Model, columns: OutputColumns) -> None:
        self._plan, self._model, self._columns = plan, model, columns
        self._shift = AppliedForces.of(model.reduced, plan.excited.force_patterns).shift
        self._squares = np.zeros((2, model.modes))  # of errors, and of amplitudes

    def add(self, rows: Floats, counted: Flags, first: int, stride: int) -> None:
        """Add outputs at the starts of every `stride` steps from `first` on, if they count."""
        amplitude = self._columns.amplitudes(rows)
        steps = slice(first, first + stride * len(rows), stride)
        error = self._error(amplitude, steps) * counted[:, np.newaxis]
        size = np.abs(amplitude)
        self._squares += (np.minimum(error, size) ** 2).sum(axis=0), (size**2).sum(axis=0)

    def _error(self, amplitude: Complexes, steps: slice) -> Floats:
        """Return the error of |a_j| (steps, modes); 0 outside the friction table."""
        model = self._model
        force, frequency, scale = self._plan.excited.step_loads(self._plan.schedule, steps)
        flow = ForcedFlow.of(model, frequency, force, self._shift)
        flow.inputs["limit_scale"] = scale[:, 0]
        effective = np.minimum(
            np.abs(flow.effective(amplitude)) / scale, model.table.amplitude_range
        )
        distance = np.abs(frequency / model.reduced.carrier - 1.0).max(axis=1)
        stated = model.accuracy.total + model.detuning_error(distance)[:, np.newaxis]
        beyond = np.maximum(stated - model.accuracy.tolerance, 0.0) * model.error_scale(effective)
        factor, now = coupling_factor(model.reduced, frequency), flow.balance(amplitude)
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
        found = model.accuracy.findings()
        if np.any(error > allowed):
            reached = np.array(plan.schedule.frequency_range(plan.excited.modes))
            found += model.detuning_findings(reached)
            reason += f", above {percentage(allowed)}. Use a shorter frequency sweep, or compare "
            reason += "with slipmode validate"
            found.append(Finding("amplitudes", choice, reason, "warning"))
        elif error.any():
            found.append(Finding("amplitudes", choice, reason))
        return found
