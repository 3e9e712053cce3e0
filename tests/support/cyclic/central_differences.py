"""All sectors with Jenkins contacts by central differences, under several waves of forces.

Of second order in the step; shares no code with the core.
"""

import numpy as np

from slipmode.rom.structure.matrices import as_dense


def carriers(structure, law, forces, frequencies, *, duration, step, last):
    """Complex amplitudes c of 2 Re(c exp(i Omega t)) of all DOFs, (frequencies, n).

    `forces` (frequencies, n) complex load by Re(f exp(i Omega t)); the fit is to the time `last`.
    """
    M, C, K, W = (
        as_dense(each)
        for each in (
            *(structure.mass, structure.damping, structure.stiffness),
            structure.directions,
        )
    )
    new = np.linalg.inv(M / step**2 + C / (2.0 * step))
    now, old = new @ (2.0 * M / step**2 - K), new @ (C / (2.0 * step) - M / step**2)
    on_contacts = new @ W
    x_old, x, z = np.zeros(len(M)), np.zeros(len(M)), np.zeros(W.shape[1])
    reach = law.limit / law.stiffness
    turn = np.exp(1j * step * np.asarray(frequencies))
    phase = np.ones(len(turn), dtype=complex)
    loads = (np.asarray(forces) @ new.T).T
    steps, kept = round(duration / step), round(last / step)
    motion = np.empty((kept, len(M)))
    for n in range(steps):
        moved = x @ W
        z = np.clip(z, moved - reach, moved + reach)
        f = law.stiffness * (moved - z)
        x_old, x = x, now @ x + old @ x_old - on_contacts @ f + (loads @ phase).real
        phase *= turn
        if n >= steps - kept:
            motion[n - steps + kept] = x
    times = step * (np.arange(steps - kept, steps) + 1.0)
    angles = np.outer(times, frequencies)
    columns = np.hstack((np.cos(angles), -np.sin(angles)))
    fitted, *_ = np.linalg.lstsq(2.0 * columns, motion, rcond=None)
    real, imaginary = np.split(fitted, 2)
    return real + 1j * imaginary
