"""Motion of all sectors of a bladed disk, at the end of a window."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Model
from slipmode.rom.laws.states import contact_states
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.waves import Waves
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.keys import Window

SAMPLES = 512  # of a window: 8 periods at 64 samples a period


def shown_dof(plan: Plan, waves: Waves) -> int:
    """Return the DOF that is shown: the first of output.elastic, or the one that moves most."""
    chosen = plan.scene.output.elastic
    return chosen[0] if chosen else int(np.abs(waves.waves[0].shape).argmax())


def record_disk(
    plan: Plan, recorder: Recorder, model: Model, trajectory: SlowTrajectory, window: Window
) -> None:
    """Record one DOF, and the state of the first contact, of every sector."""
    waves = plan.excited.waves
    assert waves is not None
    times = plan.schedule.sample_times(window)[-SAMPLES:]
    elements, sectors = waves.law.elements(waves.structure.n_contacts), waves.structure.sectors
    moved, states = [], []
    for angle in 2.0 * np.pi * np.arange(sectors) / sectors:
        dofs = [shown_dof(plan, waves)]
        motion = waves.sector.motion(model, trajectory, times, dofs, float(angle))
        moved.append(motion.elastic[:, 0])
        found = contact_states(elements, motion.displacement, motion.force)
        states.append(found.state[:, 0])
    recorder.write(channels.DISK, times, np.column_stack((*moved, *states)))
