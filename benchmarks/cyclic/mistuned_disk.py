"""A mistuned disk of 24 blades: a sweep beside full order, and many patterns.

    python -m benchmarks.mistuned_disk

Processor time of 1000 cycles of a sweep from rest, with 25 samples of all blades, and of the
integration of all sectors with 64 steps per period; of 60 frequencies of 100 patterns. The
least of several runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from slipmode import rom
from slipmode.rom import full

BLADES, ORDER, HIGHEST, CYCLES, SAMPLES, RUNS = 24, 3, 1e5, 1000, 25, 5


def processor_time(task: Callable[[], Any]) -> float:
    """Return the least processor time of a task in some runs [s]."""
    times = []
    for _ in range(RUNS):
        begun = time.process_time()
        task()
        times.append(time.process_time() - begun)
    return min(times)


def sweeps(stiffness: float, limit: float, force: float) -> tuple[float, float]:
    """Return the processor times of a sweep by amplitudes and by full order [s]."""
    disk, law = (
        rom.lumped_disk(BLADES, 1e-5, blade_stiffnesses=(1e6, 4e6)),
        rom.Jenkins(limit, stiffness),
    )
    deviation = 0.02 * np.random.default_rng(3).standard_normal(BLADES)
    natural = rom.travelling_wave(disk, law, ORDER).frequency
    omega, end = 0.96 * natural, 1.01 * natural
    duration = 2.0 * np.pi * CYCLES / omega
    mistuned = rom.MistunedDisk(disk, law, deviation, HIGHEST)
    flows = [mistuned.flow(omega, ORDER, {2: force}) for _ in range(RUNS)]

    def by_amplitudes() -> None:
        run = flows.pop()
        run.step(0.0, magnitude=1.0)
        for frequency in np.linspace(omega, end, SAMPLES + 1)[1:].tolist():
            run.step(duration / SAMPLES, frequency=frequency)
            run.amplitude(2)

    structure = disk.annulus(deviation)
    pattern = disk.around(np.array([0.0, 0.0, force], dtype=complex), ORDER)
    forced = full.Excitation.harmonic(
        structure, (pattern.real, -pattern.imag), 2 * (omega,), (0.0, -0.5 * np.pi)
    )
    contacts = rom.Contacts([(law, [j]) for j in range(BLADES)])

    def by_full_order() -> None:
        times = np.array([duration / 5])
        full.integrate(structure, contacts, forced, times, outputs=[2])

    return processor_time(by_amplitudes), 5.0 * processor_time(by_full_order)


def patterns(count: int, frequencies: int) -> float:
    """Return the processor time of steady states with local contacts [s]."""
    disk, law = rom.lumped_disk(BLADES, 1e-5, blade_stiffnesses=(1e6, 4e6)), rom.Jenkins(1.0, 5e4)
    deviation = 0.02 * np.random.default_rng(3).standard_normal((count, BLADES))
    natural = rom.travelling_wave(disk, law, ORDER).frequency
    omega = natural * np.linspace(0.965, 1.02, frequencies)
    disks = rom.MistunedDisk(disk, law, deviation, HIGHEST)
    return processor_time(lambda: disks.response(omega, ORDER, {2: 4.0}, local=True))


def main() -> None:
    """Print processor times and their ratios."""
    for name, problem in (("weak", (2e4, 1.0, 6.0)), ("strong", (2e5, 4.0, 10.0))):
        slow, fast = sweeps(*problem)
        ratio = f"full order {fast:.2f} s, ratio {fast / slow:.0f}"
        print(f"{name} joints, {CYCLES} cycles: {slow:.4f} s, {ratio}")
    print(f"100 patterns, 60 frequencies: {patterns(100, 60):.1f} s")


if __name__ == "__main__":
    main()
