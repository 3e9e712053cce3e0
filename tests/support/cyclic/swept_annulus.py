"""All sectors under a swept excitation, integrated in full, and carriers of their motion."""

import numpy as np
from cyclic.full_annulus import law_of_all

from slipmode.rom import full

SAMPLES = 32  # a period


def swept(disk, law, deviation, engine_order, force, frequencies, cycles, dof):
    """Return times, carrier angles and displacements of a DOF of all blades, from rest.

    The frequency goes from the first to the second within the first number of cycles, of the first
    frequency, and stays for the second number.
    """
    structure, (start, end) = disk.annulus(deviation), frequencies
    period = 2.0 * np.pi / start
    duration, rest = period * np.asarray(cycles)
    f = disk.around(np.asarray(force, dtype=complex), engine_order)
    zero = np.zeros((2, 2))
    rate = np.array([2 * [(end - start) / duration], [0.0, 0.0]])
    forced = full.Excitation(
        patterns=(f.real, -f.imag),
        start=[0.0, duration],
        amplitude=zero + 1.0,
        amplitude_rate=zero,
        frequency=np.array([2 * [start], 2 * [end]]),
        frequency_rate=rate,
        phase=np.array(2 * [[0.0, -0.5 * np.pi]]),
        phase_rate=zero,
    )
    times = np.arange(0.0, duration + rest, period / SAMPLES)
    outputs = np.arange(dof, structure.n_dofs, disk.free_dofs.size)
    motion = full.integrate(structure, law_of_all(disk, law), forced, times, outputs=outputs)
    return times, forced.at(times)[0][:, 0], motion.displacement


def carriers(times, angle, motion, at, half):
    """Return c of 2 Re(c exp(i angle)) at some times, from windows of twice a half width [s].

    c changes linearly within a window; third harmonic and mean are fitted, too.
    """
    found = []
    for time in at:
        inside = np.abs(times - time) <= half
        since = ((times[inside] - time) / half)[:, np.newaxis]
        turn, third = np.exp(1j * angle[inside]), np.exp(3j * angle[inside])
        waves = 2.0 * np.column_stack((turn.real, -turn.imag))
        other = np.column_stack((third.real, third.imag, np.ones(len(since))))
        weight = np.cos(0.5 * np.pi * since)
        columns = weight * np.hstack((waves, since * waves, other))
        fitted, *_ = np.linalg.lstsq(columns, weight * motion[inside], rcond=None)
        found.append(fitted[0] + 1j * fitted[1])
    return np.array(found)
