"""A pass of travelling waves of a bladed disk in slow time."""

from __future__ import annotations

from typing import cast

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.states import contact_states
from slipmode.rom.slow.motion import reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.waves import ExcitedWaves
from slipmode.runner.recording import channels
from slipmode.runner.scene.scene import Window
from slipmode.runner.transients.motion import FastMotion
from slipmode.runner.transients.passes.slow import SlowPass

SAMPLES = 512  # of a window: 8 periods at 64 samples a period


class WavePass(SlowPass):
    """Steps of a component through slow time; the motion is of sector 0."""

    def _slow_motion(self, slow: SlowTrajectory, times: Floats) -> FastMotion:
        model, sector = self._model, cast(ExcitedWaves, self._plan.excited).sector
        moved = sector.motion(model, slow, times, self._plan.scene.output.elastic)
        return FastMotion(times, **vars(moved), modal=reconstruct(model, slow, times).modal)

    def _record_end(self, window: Window, slow: SlowTrajectory) -> None:
        """Record one DOF, and the state of the first contact, of every sector."""
        excited = cast(ExcitedWaves, self._plan.excited)
        disk, dofs = excited.disk, [excited.shown_dof(self._plan.scene)]
        times = self._sample_times(window)[-SAMPLES:]
        elements = excited.contacts[1].elements(disk.n_contacts)
        moved, states = [], []
        for angle in 2.0 * np.pi * np.arange(disk.sectors) / disk.sectors:
            motion = excited.sector.motion(self._model, slow, times, dofs, float(angle))
            moved.append(motion.elastic[:, 0])
            found = contact_states(elements, motion.displacement, motion.force)
            states.append(found.state[:, 0])
        self._recorder.write(channels.DISK, times, np.column_stack((*moved, *states)))
