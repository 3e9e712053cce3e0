"""A pass of a scene at full order; its amplitudes are demodulated."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.energy import full_order_balance
from slipmode.runner.transients.full_order import FullOrder, Stretch
from slipmode.runner.transients.motion import FastMotion, record_points
from slipmode.runner.transients.passes.loop import Destination, Pass

_ENERGY = 5  # fields of /energy, the last columns of the rows


class IntegratedPass(Pass[Excited]):
    """Integration of all of a scene at full order.

    Rows have the amplitudes of the modes and the fields of ``/energy``.
    """

    def __init__(self, plan: ModesPlan, destination: Destination) -> None:
        super().__init__(plan, destination)
        self._full = FullOrder(plan, plan.excited.reduced)
        self._stretch = Stretch(self._full, self._full.first())

    def _first_row(self) -> Floats:
        """Return the amplitudes that are given; nothing has moved."""
        start = np.array(self._plan.excited.initial, dtype=complex).view(float)
        return np.append(start, np.zeros(_ENERGY))[np.newaxis]

    def _step(self, steps: slice) -> Floats:
        points = self._schedule.time(slice(steps.start + 1, steps.stop + 1))
        length, stretch, rows = self._full.window, self._stretch, list[Floats]()
        last = max(self._plan.scene.run.duration, length)  # a demodulation needs a window
        while points.size:
            needed = min(points[-1] + 0.5 * length, stretch.reached + 16.0 * length, last)
            stretch.advance(needed)  # bounds the memory
            known = last if stretch.reached >= last else stretch.reached - 0.5 * length
            now, points = np.split(points, [np.searchsorted(points, known, "right")])
            if now.size:
                slow, (_, frequency, _) = stretch.slow(now), self._full.excitation.at(now)
                natural = self._plan.excited.reduced.frequency
                energy = full_order_balance(natural, frequency, slow)
                rows.append(np.hstack((slow.amplitude.view(float), energy)))
        return np.vstack(rows)

    def _record(self, rows: Floats) -> None:
        amplitude, energy = np.split(rows, [-_ENERGY], axis=1)
        record_points(self._plan, self._recorder, self._recorded, amplitude, energy)

    def _record_window(self, window: Window) -> None:
        def motion_at(times: Floats) -> tuple[FastMotion, float, Floats]:
            angle, *_ = self._full.excitation.at(times)
            return self._stretch.motion(times), 1.0, angle % (2.0 * np.pi)

        self._record_motion(window, self._plan.excited.contacts[0], motion_at)
