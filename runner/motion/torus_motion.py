"""Contact motion over the phases of both carriers, at the amplitudes of one instant."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.slow.motion import SPIN_UP_PERIODS, reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory

LINES, SAMPLES = 32, 64  # phases of B, and of A, at which the motion is computed


def carrier_phases(trajectory: SlowTrajectory, times: Floats) -> Floats:
    """Return the carrier angles theta_j, from 0 to 2 pi, at times of a trajectory, (n, modes)."""
    steps = trajectory.time.size - 1
    k = np.clip(np.searchsorted(trajectory.time, times, side="right") - 1, 0, steps - 1)
    later = (times - trajectory.time[k])[:, np.newaxis]
    turned = (trajectory.frequency[k] + 0.5 * trajectory.frequency_rate[k] * later) * later
    return np.asarray((trajectory.angle[k] + turned) % (2 * np.pi))


def torus_motion(model: Model, trajectory: SlowTrajectory, time: float) -> Floats:
    """Return the motion of contact 0 over the phases of both carriers at constant amplitudes.

    Amplitudes, frequencies and forces are of the next point of the trajectory at a time [s]. The
    ratio of the frequencies is rounded to an odd multiple of 1 / LINES, so that the march closes
    after as many periods of A and covers the phases of B evenly; the frequencies act on the
    contacts through rates only. Rows (LINES * SAMPLES, 5) have the phases of A and B [rad],
    displacement [m], velocity [m/s] and friction force [N], in the order of the march.
    """
    k = min(int(np.searchsorted(trajectory.time, time)), trajectory.time.size - 1)
    of_a, of_b = trajectory.point_frequency[k]
    odd = 2 * max(0, round(0.5 * (of_b / of_a * LINES - 1))) + 1
    frequency = np.array([of_a, of_a * odd / LINES])
    period = 2 * np.pi / of_a
    first = int(np.ceil(SPIN_UP_PERIODS * of_a / frequency.min())) * SAMPLES
    times = period / SAMPLES * np.arange(first, first + LINES * SAMPLES)
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
    )
    motion = reconstruct(model, held, times)
    columns = (motion.displacement, motion.velocity, motion.force)
    phases = np.outer(times, frequency) % (2 * np.pi)
    return np.column_stack([phases, *(column[:, 0] for column in columns)])
