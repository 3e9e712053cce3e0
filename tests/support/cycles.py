"""Full-order motion of self-excited modes: the amplitude and frequency that it settles to."""

import numpy as np

from slipmode.rom import full


def demodulated(time, signal, frequency):
    """Complex amplitude of the line near a frequency [rad/s], and its frequency, of a signal."""
    half = time.size // 2
    for _ in range(4):
        lines = []
        for part in (slice(0, half), slice(half, 2 * half)):
            t, x = time[part], signal[part]
            weight = np.sin(np.pi * (np.arange(half) + 0.5) / half) ** 8
            lines.append((weight / weight.sum()) @ (x * np.exp(-1j * frequency * t)))
        turned = np.angle(lines[1] / lines[0])
        frequency += turned / (time[half] - time[0])
    return lines[1], frequency


def settled(structure, law, reduced, cycle, force=None, *, periods, steps=128, off=1.05):
    """Amplitudes and frequencies (modes,) at full order, from near a limit cycle of the slow flow.

    Of the last quarter of some `periods` of the slowest mode.
    """
    body = full.aeroelastic(structure, reduced)
    force = [{}] * cycle.amplitude.size if force is None else force
    excitation = full.Excitation.harmonic(body, force, cycle.frequency)
    a, shapes = off * cycle.amplitude, reduced.mode_shapes
    start = full.State(
        time=0.0,
        displacement=shapes @ (2.0 * a.real),
        velocity=shapes @ (2.0 * np.real(1j * cycle.frequency * a)),
    )
    end = 2.0 * np.pi / cycle.frequency.min() * periods
    times = np.linspace(0.75, 1.0, 64 * periods) * end
    rows = (structure.mass @ shapes).T
    motion = full.integrate(
        body, law, excitation, times, steps_per_period=steps, outputs=rows, start=start
    )
    found = [
        demodulated(motion.time, signal, frequency)
        for signal, frequency in zip(motion.displacement.T, cycle.frequency, strict=True)
    ]
    return np.array([a for a, _ in found]), np.array([frequency for _, frequency in found])
