"""The slow trajectory of a run, from which fast motion is reconstructed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.fmu import Steppable
from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.force_response import AppliedForces, phasor
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.scene import Window
from slipmode.runner.scene.schedule import LIMIT_SCALE, Schedule, rate_of


@frozen
class OutputColumns:
    """Columns of the outputs of a component."""

    parts: list[int]  # Real and imaginary part of the amplitude of each mode in turn
    angle: list[int]
    power: list[int]  # Input power, dissipated power, dissipated energy

    @classmethod
    def of(cls, names: Sequence[str], modes: Sequence[str]) -> OutputColumns:
        """Return the columns of outputs with these names."""
        column = {name: k for k, name in enumerate(names)}
        return cls(
            [column[f"{mode}_{part}"] for mode in modes for part in ("re", "im")],
            [column[f"theta_{mode}"] for mode in modes],
            [column[name] for name in ("input_power", "dissipated_power", "dissipated_energy")],
        )

    def amplitudes(self, outputs: Floats) -> Complexes:
        """Return the amplitudes (rows, modes) of outputs (rows, names)."""
        return np.ascontiguousarray(outputs[:, self.parts]).view(complex)


def output_row(component: Steppable) -> Floats:
    """Return the present outputs of a component as a row, (1, names)."""
    now = component.outputs()
    return np.array([[now[name] for name in component.output_names]])


def slow_trajectory(
    plan: Plan, model: Model, names: Sequence[str], outputs: Floats, first: int = 0
) -> SlowTrajectory:
    """Return the trajectory of a component's outputs (steps + 1, names) from point `first` on."""
    excited, schedule = plan.excited, plan.schedule
    steps = slice(first, first + len(outputs) - 1)
    columns = OutputColumns.of(names, excited.modes)
    force_response = AppliedForces.of(model.reduced, excited.force_patterns, plan.structure)
    script, angle = scripted(excited, schedule, steps), outputs[:, columns.angle]
    before = slice(max(first - 1, 0), steps.stop)
    start, end = excited.modal_forces(schedule, before)
    onset = start[1:] - end[:-1]
    scale = schedule.inputs((LIMIT_SCALE, rate_of(LIMIT_SCALE)), steps)
    if first == 0:
        onset = np.vstack((np.zeros_like(start[:1]), onset))
    varying = {}
    if np.any(scale != (1.0, 0.0)):  # limits and preloads
        varying = {"scale": scale[:, 0], "scale_rate": scale[:, 1]}
    return SlowTrajectory(
        time=schedule.time(slice(first, steps.stop + 1)),
        amplitude=columns.amplitudes(outputs),
        angle=angle,
        frequency=script.frequency,
        frequency_rate=script.frequency_rate,
        force=script.force,
        force_rate=script.force_rate,
        force_response=force_response,
        **varying,
        discontinuity=force_response.free_vibration(onset, script.frequency, angle[:-1]),
    )


@frozen
class Script:
    """Forcing at the start of each step, (steps, modes); see `SlowTrajectory`."""

    force: Complexes
    force_rate: Complexes
    frequency: Floats
    frequency_rate: Floats


def scripted(excited: Excited, schedule: Schedule, steps: slice = slice(None)) -> Script:
    """Return the forcing of the modes by the script of the scene."""
    quantities = ("force", "force_rate", "phase", "phase_rate", "frequency", "frequency_rate")
    names = [f"{quantity}_{mode}" for quantity in quantities for mode in excited.modes]
    found = np.split(schedule.inputs(names, steps), len(quantities), axis=1)
    size, size_rate, phase, phase_rate, frequency, frequency_rate = found
    per_unit = phasor(excited.modal_force, phase)
    force = size * per_unit
    force_rate = size_rate * per_unit + 1j * phase_rate * force
    return Script(force, force_rate, frequency, frequency_rate)


def sample_times(window: Window, trajectory: SlowTrajectory) -> Floats:
    """Return the equally spaced times at which a window is sampled."""
    return window_times(window, trajectory.time, trajectory.frequency, trajectory.frequency_rate)


def window_times(window: Window, time: Floats, frequency: Floats, rate: Floats) -> Floats:
    """Return times over a window with `samples_per_period` of its highest frequency.

    From communication points (steps + 1,) [s], and carrier frequencies [rad/s] at the start of
    each step, with their rates [rad/s^2], (steps, modes).
    """
    inside = (time[1:] >= window.start) & (time[:-1] <= window.end)
    later = frequency + rate * np.diff(time)[:, None]
    fastest = max(frequency[inside].max(), later[inside].max())
    periods = (window.end - window.start) * fastest / (2 * np.pi)
    count = max(int(np.ceil(periods * window.samples_per_period)), 1)
    return np.linspace(window.start, window.end, count + 1)
