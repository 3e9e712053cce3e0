"""The slow trajectory of a run, from which fast motion is reconstructed."""

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
    """Return the trajectory of a component's outputs (steps + 1, names) from point `first` on."""
    excited, schedule = plan.excited, plan.schedule
    steps = slice(first, first + len(outputs) - 1)
    column = {name: k for k, name in enumerate(names)}

    def of_modes(pattern: str) -> Floats:
        return outputs[:, [column[pattern.format(mode)] for mode in excited.modes]]

    force_response = ForceResponse.of(model.reduced, excited.force_patterns, plan.structure)
    script, angle = scripted(excited, schedule, steps), of_modes("theta_{}")
    before = slice(max(first - 1, 0), steps.stop)
    start, end = excited.modal_forces(schedule, before)
    onset = start[1:] - end[:-1]
    if first == 0:
        onset = np.vstack((np.zeros_like(start[:1]), onset))
    return SlowTrajectory(
        time=schedule.time(slice(first, steps.stop + 1)),
        amplitude=of_modes("{}_re") + 1j * of_modes("{}_im"),
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
    """Forcing at the start of each step, (steps, modes); see `SlowTrajectory`."""

    force: Complexes
    force_rate: Complexes
    frequency: Floats
    frequency_rate: Floats

    __repr__ = short_repr


def scripted(excited: Excited, schedule: Schedule, steps: slice) -> Script:
    """Return the forcing of the modes by the script of the scene."""
    names = [f"{quantity}_{mode}" for quantity in _SCRIPTED for mode in excited.modes]
    found = np.split(schedule.inputs(names, steps), len(_SCRIPTED), axis=1)
    size, size_rate, phase, phase_rate, frequency, frequency_rate = found
    factor = [excited.reduced.modal_force(j, f) for j, f in enumerate(excited.force_patterns)]
    per_unit = phasor(factor, phase)
    force = size * per_unit
    force_rate = size_rate * per_unit + 1j * phase_rate * force
    return Script(force, force_rate, frequency, frequency_rate)


def _limit_scale(schedule: Schedule, steps: slice) -> dict[str, Floats]:
    """Return the scale of limits and preloads and its rate; nothing if it is always 1."""
    names = (LIMIT_SCALE, rate_of(LIMIT_SCALE))
    scale, rate = schedule.inputs(names, steps).T
    return {} if np.all(scale == 1.0) and not rate.any() else {"scale": scale, "scale_rate": rate}


def sample_times(window: Window, trajectory: SlowTrajectory) -> Floats:
    """Return the equally spaced times at which a window is sampled."""
    return window_times(window, trajectory.time, trajectory.frequency, trajectory.frequency_rate)


def window_times(window: Window, time: Floats, frequency: Floats, rate: Floats) -> Floats:
    """Return times over a window with `samples_per_period` of its highest frequency.

    Parameters
    ----------
    time : (steps + 1,) ndarray
        Communication points [s].
    frequency, rate : (steps, modes) ndarray
        Carrier frequencies [rad/s] at the start of each step, and their rates [rad/s^2].
    """
    inside = (time[1:] >= window.start) & (time[:-1] <= window.end)
    later = frequency + rate * np.diff(time)[:, None]
    fastest = max(frequency[inside].max(), later[inside].max())
    periods = (window.end - window.start) * fastest / (2 * np.pi)
    count = max(int(np.ceil(periods * window.samples_per_period)), 1)
    return np.linspace(window.start, window.end, count + 1)
