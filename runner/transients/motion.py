"""The motion of a run: its slow trajectory, fast motion in windows, and what is recorded of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Self

import numpy as np
import scipy

from slipmode.rom import Model, Reduced
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.laws.elements import Elements
from slipmode.rom.laws.states import STATES, contact_states
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.motion import SPIN_UP_PERIODS, reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.excited import Excited, contact_channels, tangents
from slipmode.runner.plan.plan import ModesPlan, Plan

# Shares of states are then within 0.3 % (tests/runner/scene/test_shared_tone.py).
_STEPS_PER_SAMPLE = 8

POWERS = ("input_power", "dissipated_power", "dissipated_energy")  # outputs of components

if TYPE_CHECKING:
    from slipmode.runner.recording.record import Recorder
    from slipmode.runner.transients.band import SampleBand


@frozen
class FastMotion:
    """Motion at given times, in slow time or at full order."""

    time: Floats  # (n,) [s]
    # displacement, velocity, force: (n, N_c): Motion of the contacts [m], [m/s], and force on them
    # [N]
    displacement: Floats
    velocity: Floats
    force: Floats
    modal: Floats  # (n, modes): Displacements of the retained modes [kg^1/2 m]
    elastic: Floats  # (n, dofs): Displacements of the scene's output.elastic [m]

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return motions that follow one another as one."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def record_points(
    plan: Plan[Excited],
    recorder: Recorder,
    first: int,
    amplitude: Floats,
    energy: Floats,
    band: SampleBand | None = None,
) -> None:
    """Record the slow channels of communication points from number `first` on.

    `amplitude` (points, 2 modes) has the real and imaginary part of each a_j, `energy` has
    the fields of ``/energy``, (points, 5). `band` is of the samples, if the model has them.
    """
    points = slice(first, first + len(amplitude))
    time = plan.schedule.time(points)
    moduli = np.hypot(amplitude[:, 0::2], amplitude[:, 1::2])
    parts = (amplitude, moduli) if band is None else (amplitude, moduli, band.at(points))
    recorder.write("/modes", time, np.hstack(parts))
    inputs = ("force", "frequency", "phase")
    names = [f"{name}_{mode}" for mode in plan.excited.modes for name in inputs]
    recorder.write("/forcing", time, plan.schedule.at_points(names, points))
    recorder.write("/energy", time, energy)
    if plan.scene.wear:
        recorder.write("/control", time, plan.schedule.at_points(["limit_scale"], points))


def record_contacts(
    recorder: Recorder,
    reduced: Reduced,
    motion: FastMotion,
    scale: Floats | float = 1.0,
    prefix: str = "",
) -> Floats | None:
    """Record the motion of contacts; return the shares of the states of elastic ones."""
    moved, elements = (motion.displacement, motion.velocity, motion.force), reduced.contacts
    listed = contact_channels(reduced, prefix)
    if elements is None:
        for i, channel in enumerate(listed):
            rows = np.stack([part[:, i] for part in moved], axis=1)
            recorder.write(channel.topic, motion.time, rows)
        return None
    states = contact_states(elements, motion.displacement, motion.force, scale)
    for k, (channel, element) in enumerate(zip(listed, elements.element, strict=True)):
        count = tangents(element)
        along = element["column"][: max(count, 1)].tolist()
        columns = [part[:, i] for i in along for part in moved]
        if count:
            normal = element["column"][count]
            columns += [motion.displacement[:, normal], motion.velocity[:, normal]]
            columns += [states.normal_force[:, k], states.gap[:, k]]
        rows = np.stack([*columns, states.state[:, k]], axis=1)
        recorder.write(channel.topic, motion.time, rows)
    return states.shares()


def force_along(elements: Elements, time: Floats, displacement: Floats) -> Floats:
    """Return the forces of contacts that move from rest, (n, N_c).

    Between the samples `displacement` (n, N_c), at `time` (n,), contacts take several steps.
    """
    samples = np.arange(time.size * _STEPS_PER_SAMPLE - _STEPS_PER_SAMPLE + 1) / _STEPS_PER_SAMPLE
    fine = np.interp(samples, np.arange(time.size), time)
    force, _ = elements.march(scipy.interpolate.CubicSpline(time, displacement)(fine))
    return force[::_STEPS_PER_SAMPLE]


def shares_in_words(shares: Floats) -> str:
    """Return in words the shares of time (elements, 3) that contacts spend in each state."""
    parts = []
    for name, part in zip(STATES, shares.T, strict=True):
        low, high = part.min(), part.max()
        start = "" if high - low < 5e-3 else f"{100 * low:.0f} to "
        parts.append(f"{name} {start}{100 * high:.0f} %")
    return f"contacts are {', '.join(parts)} of the time"


@frozen
class OutputColumns:
    """Columns of the outputs of a component."""

    parts: list[int]  # Real and imaginary part of the amplitude of each mode in turn
    angle: list[int]  # Of the carrier of each mode, or tone
    power: list[int]  # `POWERS`

    @classmethod
    def of(cls, names: Sequence[str], excited: Excited) -> OutputColumns:
        """Return the columns of outputs with these names."""
        parts = [f"{mode}_{part}" for mode in excited.mode_names for part in ("re", "im")]
        wanted = parts, [f"theta_{tone}" for tone in excited.modes], POWERS
        return cls(*([list(names).index(name) for name in each] for each in wanted))

    def amplitudes(self, outputs: Floats) -> Complexes:
        """Return the amplitudes (rows, modes) of outputs (rows, names)."""
        return np.ascontiguousarray(outputs[:, self.parts]).view(complex)


def slow_trajectory(
    plan: ModesPlan, model: Model, names: Sequence[str], outputs: Floats, first: int = 0
) -> SlowTrajectory:
    """Return the trajectory of a component's outputs (steps + 1, names) from point `first` on."""
    excited, schedule = plan.excited, plan.schedule
    steps = slice(first, first + len(outputs) - 1)
    columns = OutputColumns.of(names, excited)
    force_response = AppliedForces.of(model.reduced, excited.force_patterns, excited.structure)
    now, rate = excited.step_loads(schedule, steps), excited.load_rates(schedule, steps)
    last = slice(max(first - 1, 0), max(steps.stop - 1, 0))
    before = excited.loads(partial(schedule.at_ends, steps=last)).force
    onset = now.force - (before if first else np.vstack((now.force[:1], before)))
    angle = outputs[:, columns.angle]
    return SlowTrajectory(
        time=schedule.time(slice(first, steps.stop + 1)),
        amplitude=columns.amplitudes(outputs),
        angle=angle,
        frequency=now.frequency,
        frequency_rate=rate.frequency,
        force=now.force,
        force_rate=rate.force,
        force_response=force_response,
        discontinuity=force_response.free_vibration(onset, now.frequency, angle[:-1]),
        scale=now.scale[:, 0],
        scale_rate=rate.scale[:, 0],
    )


def carrier_phases(trajectory: SlowTrajectory, times: Floats) -> Floats:
    """Return the carrier angles theta_j, from 0 to 2 pi, at times of a trajectory, (n, modes)."""
    steps = trajectory.time.size - 1
    k = np.clip(np.searchsorted(trajectory.time, times, side="right") - 1, 0, steps - 1)
    later = (times - trajectory.time[k])[:, np.newaxis]
    turned = (trajectory.frequency[k] + 0.5 * trajectory.frequency_rate[k] * later) * later
    return np.asarray((trajectory.angle[k] + turned) % (2 * np.pi))


def torus_motion(model: Model, trajectory: SlowTrajectory, time: float) -> Floats:
    """Return the motion of contact 0 over the phases of both carriers at constant amplitudes.

    Amplitudes, frequencies, forces and limits are of the next point of the trajectory at a time
    [s]. The ratio of the frequencies is rounded to an odd multiple of 1 / 32, so that the march
    closes after 32 periods of A and covers the phases of B evenly; the frequencies act on the
    contacts through rates only. Rows (32 * 64, 5) have the phases of A and B [rad], displacement
    [m], velocity [m/s] and friction force [N], in the order of the march.
    """
    lines, samples = 32, 64  # phases of B, and of A
    k = min(int(np.searchsorted(trajectory.time, time)), trajectory.time.size - 1)
    of_a, of_b = trajectory.point_frequency[k]
    odd = 2 * max(0, round(0.5 * (of_b / of_a * lines - 1))) + 1
    frequency = np.array([of_a, of_a * odd / lines])
    period = 2 * np.pi / of_a
    first = int(np.ceil(SPIN_UP_PERIODS * of_a / frequency.min())) * samples
    times = period / samples * np.arange(first, first + lines * samples)
    # eight steps a period of the slow amplitudes, which are constant here
    steps = int(np.ceil(times[-1] / period * 8)) + 1
    every = np.ones((steps + 1, 1))
    clock = np.linspace(0.0, steps * period / 8, steps + 1)
    force = every[1:] * trajectory.point_force[k]
    held = SlowTrajectory(
        time=clock,
        amplitude=every * trajectory.amplitude[k],
        angle=np.outer(clock, frequency),
        frequency=every[1:] * frequency,
        frequency_rate=np.zeros((steps, 2)),
        force=force,
        force_rate=np.zeros_like(force),
        force_response=trajectory.force_response,
        scale=every[1:, 0] * trajectory.scale_at(trajectory.time[k : k + 1]),
    )
    motion = reconstruct(model, held, times)
    columns = (motion.displacement, motion.velocity, motion.force)
    phases = np.outer(times, frequency) % (2 * np.pi)
    return np.column_stack([phases, *(column[:, 0] for column in columns)])
