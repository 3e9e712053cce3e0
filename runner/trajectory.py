"""The slow trajectory of a run, as the reconstruction of fast motion takes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.force_response import ForceResponse, phasor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.scene import Window
from slipmode.runner.scene.schedule import LIMIT_SCALE, Schedule, rate_of

_SCRIPTED = ("force", "force_rate", "phase", "phase_rate", "frequency", "frequency_rate")


def slow_trajectory(
    plan: Plan, model: Model, names: Sequence[str], outputs: Floats, first: int = 0
) -> SlowTrajectory:
    """Trajectory through the outputs (steps + 1, names) of a component from a point on."""
    excited, schedule = plan.excited, plan.schedule
    steps = slice(first, first + len(outputs) - 1)
    column = {name: k for k, name in enumerate(names)}

    def taken(pattern: str) -> Floats:
        return outputs[:, [column[pattern.format(mode)] for mode in excited.modes]]

    force_response = ForceResponse.of(model.reduced, excited.force_patterns, plan.structure)
    script, angle = scripted(excited, schedule, steps), taken("theta_{}")
    before = slice(max(first - 1, 0), steps.stop)
    start, end = excited.modal_forces(schedule, before)
    onset = start[1:] - end[:-1]
    if first == 0:
        onset = np.vstack((np.zeros_like(start[:1]), onset))
    return SlowTrajectory(
        time=schedule.time(slice(first, steps.stop + 1)),
        amplitude=taken("{}_re") + 1j * taken("{}_im"),
        angle=angle,
        frequency=script.frequency,
        frequency_rate=script.frequency_rate,
        force=script.force,
        force_rate=script.force_rate,
        force_response=force_response,
        **_limit_scale(schedule, steps),
        discontinuity=force_response.free_vibration(
            model.reduced, onset, script.frequency, angle[:-1]
        ),
    )


@dataclass(frozen=True, eq=False)
class Script:
    """Forcing at the start of steps, (steps, modes); as in `SlowTrajectory`."""

    force: Complexes
    force_rate: Complexes
    frequency: Floats
    frequency_rate: Floats

    __repr__ = short_repr


def scripted(excited: Excited, schedule: Schedule, steps: slice) -> Script:
    """Forcing of the modes as it is scripted."""
    names = [f"{quantity}_{mode}" for quantity in _SCRIPTED for mode in excited.modes]
    found = np.split(schedule.inputs(names, steps), len(_SCRIPTED), axis=1)
    size, size_rate, phase, phase_rate, frequency, frequency_rate = found
    factor = [excited.reduced.modal_force(j, f) for j, f in enumerate(excited.force_patterns)]
    per_unit = phasor(factor, phase)
    force = size * per_unit
    force_rate = size_rate * per_unit + 1j * phase_rate * force
    return Script(force, force_rate, frequency, frequency_rate)


def _limit_scale(schedule: Schedule, steps: slice) -> dict[str, Floats]:
    """Limits and preloads over the steps, where they are scripted."""
    names = (LIMIT_SCALE, rate_of(LIMIT_SCALE))
    scale, rate = schedule.inputs(names, steps).T
    return {} if np.all(scale == 1.0) and not rate.any() else {"scale": scale, "scale_rate": rate}


def sample_times(window: Window, trajectory: SlowTrajectory) -> Floats:
    """Equally spaced times over a window, at least as dense as asked for at every frequency."""
    return window_times(window, trajectory.time, trajectory.frequency, trajectory.frequency_rate)


def window_times(window: Window, time: Floats, frequency: Floats, rate: Floats) -> Floats:
    """The same for frequencies and rates (steps, modes) between times (steps + 1,)."""
    inside = (time[1:] >= window.start) & (time[:-1] <= window.end)
    later = frequency + rate * np.diff(time)[:, None]
    fastest = max(frequency[inside].max(), later[inside].max())
    periods = (window.end - window.start) * fastest / (2 * np.pi)
    count = max(int(np.ceil(periods * window.samples_per_period)), 1)
    return np.linspace(window.start, window.end, count + 1)
