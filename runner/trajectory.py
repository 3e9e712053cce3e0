"""The slow trajectory of a run, as the reconstruction of fast motion takes it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.force_response import ForceResponse, phasor
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.scene import Window
from slipmode.runner.scene.schedule import LIMIT_SCALE, Schedule, rate_of


def slow_trajectory(
    plan: Plan, model: Model, names: Sequence[str], outputs: Floats, first: int = 0
) -> SlowTrajectory:
    """Trajectory through the outputs (steps + 1, names) of a component from a point on."""
    excited, schedule = plan.excited, plan.schedule
    steps = slice(first, first + len(outputs) - 1)
    column = {name: k for k, name in enumerate(names)}
    factor = [model.reduced.modal_force(j, f) for j, f in enumerate(excited.force_patterns)]

    def taken(pattern: str) -> Floats:
        return outputs[:, [column[pattern.format(mode)] for mode in excited.modes]]

    def scripted(quantity: str) -> Floats:
        return schedule.inputs([f"{quantity}_{mode}" for mode in excited.modes], steps)

    per_unit = phasor(factor, scripted("phase"))
    force, growing = scripted("force") * per_unit, scripted("force_rate") * per_unit
    force_response = ForceResponse.of(model.reduced, excited.force_patterns, plan.structure)
    frequency, angle = scripted("frequency"), taken("theta_{}")
    before = slice(max(first - 1, 0), steps.stop)
    start, end = excited.modal_forces(schedule, before)
    onset = start[1:] - end[:-1]
    if first == 0:
        onset = np.vstack((np.zeros_like(start[:1]), onset))
    return SlowTrajectory(
        time=schedule.time(slice(first, steps.stop + 1)),
        amplitude=taken("{}_re") + 1j * taken("{}_im"),
        angle=angle,
        frequency=frequency,
        frequency_rate=scripted("frequency_rate"),
        force=force,
        force_rate=growing + 1j * scripted("phase_rate") * force,
        force_response=force_response,
        **_limit_scale(schedule, steps),
        discontinuity=force_response.free_vibration(model.reduced, onset, frequency, angle[:-1]),
    )


def _limit_scale(schedule: Schedule, steps: slice) -> dict[str, Floats]:
    """Limits and preloads over the steps, where they are scripted."""
    names = (LIMIT_SCALE, rate_of(LIMIT_SCALE))
    scale, rate = schedule.inputs(names, steps).T
    return {} if np.all(scale == 1.0) and not rate.any() else {"scale": scale, "scale_rate": rate}


def sample_times(window: Window, trajectory: SlowTrajectory) -> Floats:
    """Equally spaced times over a window, at least as dense as asked for at every frequency."""
    inside = (trajectory.time[1:] >= window.start) & (trajectory.time[:-1] <= window.end)
    later = trajectory.frequency + trajectory.frequency_rate * np.diff(trajectory.time)[:, None]
    fastest = max(trajectory.frequency[inside].max(), later[inside].max())
    periods = (window.end - window.start) * fastest / (2 * np.pi)
    count = max(int(np.ceil(periods * window.samples_per_period)), 1)
    return np.linspace(window.start, window.end, count + 1)
