"""The slow trajectory of a run, as the reconstruction of fast motion takes it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.force_response import ForceResponse
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.scene import Window


def slow_trajectory(
    plan: Plan, model: Model, names: Sequence[str], outputs: Floats
) -> SlowTrajectory:
    """Trajectory through the outputs (steps + 1, names) of a component, those at t = 0 first."""
    excited, schedule = plan.excited, plan.schedule
    steps = len(outputs) - 1
    column = {name: k for k, name in enumerate(names)}
    factor = [model.reduced.modal_force(j, f) for j, f in enumerate(excited.force)]

    def taken(pattern: str) -> Floats:
        return outputs[:, [column[pattern.format(mode)] for mode in excited.modes]]

    def scripted(values: dict[str, Floats], quantity: str) -> Floats:
        return np.column_stack([values[f"{quantity}_{mode}"][:steps] for mode in excited.modes])

    turn = factor * np.exp(1j * scripted(schedule.values, "phase"))
    force = scripted(schedule.values, "force") * turn
    growing = scripted(schedule.rates, "force") * turn
    force_response = ForceResponse.of(model.reduced, excited.force, plan.structure)
    frequency, angle = scripted(schedule.values, "frequency"), taken("theta_{}")
    start, end = (forces[:steps] for forces in excited.modal_forces(schedule))
    onset = np.vstack((np.zeros_like(start[:1]), start[1:] - end[:-1]))
    return SlowTrajectory(
        time=schedule.time[: steps + 1],
        amplitude=taken("{}_re") + 1j * taken("{}_im"),
        angle=angle,
        frequency=frequency,
        frequency_rate=scripted(schedule.rates, "frequency"),
        force=force,
        force_rate=growing + 1j * scripted(schedule.rates, "phase") * force,
        force_response=force_response,
        discontinuity=force_response.free_vibration(model.reduced, onset, frequency, angle[:-1]),
    )


def sample_times(window: Window, trajectory: SlowTrajectory) -> Floats:
    """Equally spaced times over a window, at least as dense as asked for at every frequency."""
    inside = (trajectory.time[1:] >= window.start) & (trajectory.time[:-1] <= window.end)
    later = trajectory.frequency + trajectory.frequency_rate * np.diff(trajectory.time)[:, None]
    fastest = max(trajectory.frequency[inside].max(), later[inside].max())
    periods = (window.end - window.start) * fastest / (2 * np.pi)
    count = max(int(np.ceil(periods * window.samples_per_period)), 1)
    return np.linspace(window.start, window.end, count + 1)
