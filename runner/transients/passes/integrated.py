"""A pass of a scene at full order; its amplitudes are demodulated."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.energy import full_order_balance
from slipmode.runner.transients.full_order import FullOrder, Stretch
from slipmode.runner.transients.motion import FastMotion, record_points
from slipmode.runner.transients.passes.loop import Pass, Recording

_ENERGY = 5  # fields of /energy, the last columns of the outputs


class IntegratedSteps:
    """The stretch at full order from the start of a scene, stepped along its schedule.

    The outputs are the amplitudes of the modes and the fields of ``/energy``.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan, self._point = plan, 0
        self.full = FullOrder(plan, plan.excited.reduced)
        self.stretch = Stretch(self.full, self.full.first())
        self.input_names = plan.schedule.scripted
        parts = [f"{mode}_{part}" for mode in plan.excited.modes for part in ("re", "im")]
        self.output_names = (*parts, *map(str, range(_ENERGY)))

    def set_inputs(self, **values: float) -> None:
        """Set nothing: the forces follow the schedule."""

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the start, which is given; nothing has moved."""
        start = np.array(self._plan.excited.initial, dtype=complex).view(float)
        return dict(zip(self.output_names, [*start.tolist(), *_ENERGY * [0.0]], strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Return the outputs after the next steps of the schedule."""
        first = self._point + 1
        self._point += len(durations)
        points = self._plan.schedule.time(slice(first, self._point + 1))
        length, stretch, rows = self.full.window, self.stretch, list[Floats]()
        last = max(self._plan.scene.run.duration, length)  # a demodulation needs a window
        while points.size:
            needed = min(points[-1] + 0.5 * length, stretch.reached + 16.0 * length, last)
            stretch.advance(needed)  # bounds the memory
            known = last if stretch.reached >= last else stretch.reached - 0.5 * length
            now, points = np.split(points, [np.searchsorted(points, known, "right")])
            if now.size:
                rows.append(self._rows(now))
        return np.vstack(rows)

    def _rows(self, points: Floats) -> Floats:
        slow = self.stretch.slow(points)
        _, frequency, _ = self.full.excitation.at(points)
        energy = full_order_balance(self._plan.excited.reduced.frequency, frequency, slow)
        return np.hstack((slow.amplitude.view(float), energy))


class IntegratedPass(Pass[Plan]):
    """Integration of all of a scene at full order."""

    def __init__(self, plan: Plan, recording: Recording) -> None:
        self._steps = IntegratedSteps(plan)
        super().__init__(plan, recording, self._steps)

    def _record(self, rows: Floats) -> None:
        amplitude, energy = np.split(rows, [-_ENERGY], axis=1)
        record_points(self._plan, self._recorder, self._recorded, amplitude, energy)

    def _record_window(self, window: Window) -> None:
        def motion_at(times: Floats) -> tuple[FastMotion, float, Floats]:
            angle, *_ = self._steps.full.excitation.at(times)
            return self._steps.stretch.motion(times), 1.0, angle % (2.0 * np.pi)

        self._record_motion(window, self._plan.excited.contacts[0], motion_at)
