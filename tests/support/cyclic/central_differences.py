"""All sectors with Jenkins contacts by central differences, under several waves of forces.

Of second order in the step, except that modes with open contacts have their exact frequencies.
Shares no code with the core.
"""

from types import SimpleNamespace

import numpy as np
import scipy.linalg

from slipmode.rom.structure.matrices import as_dense


def between_sectors(disk):
    """Aerodynamic stiffness and damping of all sectors, (n_s N, n_s N) each, not symmetric.

    Complex coefficients act on displacement by their real part, and on velocity by their imaginary
    part over omega_0: a real equivalent, exact at omega_0. Sectors are joined by contacts and the
    DOFs of the lumped disk alone, so no direction is on its right side.
    """
    forces, N = disk.aerodynamics, disk.sectors
    D = as_dense(forces.directions)[disk.free_dofs]
    stiffness, damping = 0.0, 0.0
    for distance, l_d in forces.influence.items():
        neighbour = np.roll(np.eye(N), distance, axis=1)  # row j has sector j + distance
        stiffness = stiffness + np.kron(neighbour, D @ l_d.real @ D.T)
        damping = damping + np.kron(neighbour, D @ l_d.imag @ D.T) / forces.frequency
    return stiffness, damping


def march(structure, law, *, duration, step, last, **given):
    """Times and motion (times, n) of all DOFs in the time `last` at the end.

    `forces` (frequencies, n) complex load by Re(f exp(i Omega t)) at `frequencies`; `between` are
    a further stiffness and damping; `start` are displacement and velocity (2, n).
    """
    n = structure.n_dofs
    given = {
        "forces": np.zeros((1, n)),
        "frequencies": [0.0],
        "between": (0.0, 0.0),
        "start": np.zeros((2, n)),
    } | given
    at = SimpleNamespace(**given)
    M, C, K, W = (
        as_dense(each)
        for each in (
            *(structure.mass, structure.damping, structure.stiffness),
            structure.directions,
        )
    )
    square, modes = scipy.linalg.eigh(K, M)
    inertia = M @ modes
    differences = 4.0 * np.sin(0.5 * step * np.sqrt(square)) ** 2 / step**2
    K, C = inertia * differences @ inertia.T + at.between[0], C + at.between[1]
    new = np.linalg.inv(M / step**2 + C / (2.0 * step))
    now, old = new @ (2.0 * M / step**2 - K), new @ (C / (2.0 * step) - M / step**2)
    on_contacts = new @ W
    x = np.array(at.start[0], dtype=float)
    x_old, z = x - step * at.start[1], np.zeros(W.shape[1])
    reach = law.limit / law.stiffness
    turn = np.exp(1j * step * np.asarray(at.frequencies))
    phase = np.ones(len(turn), dtype=complex)
    loads = (np.asarray(at.forces) @ new.T).T
    steps, kept = round(duration / step), round(last / step)
    motion = np.empty((kept, n))
    for k in range(steps):
        moved = x @ W
        z = np.clip(z, moved - reach, moved + reach)
        f = law.stiffness * (moved - z)
        x_old, x = x, now @ x + old @ x_old - on_contacts @ f + (loads @ phase).real
        phase *= turn
        if k >= steps - kept:
            motion[k - steps + kept] = x
    return step * (np.arange(steps - kept, steps) + 1.0), motion


def carriers(times, motion, frequencies):
    """Complex amplitudes c of 2 Re(c exp(i Omega t)) of all DOFs, (frequencies, n)."""
    angles = np.outer(times, frequencies)
    columns = np.hstack((np.cos(angles), -np.sin(angles)))
    fitted, *_ = np.linalg.lstsq(2.0 * columns, motion, rcond=None)
    real, imaginary = np.split(fitted, 2)
    return real + 1j * imaginary


def modal(disk, wave, motion):
    """The mode of a travelling wave in the motion (..., n_s N): a exp(i Omega t) of each time."""
    k = wave.nodal_diameter
    sectors = motion.reshape(*motion.shape[:-1], disk.sectors, -1)
    turn = disk.around(np.ones(1), k).conj() / disk.sectors
    mass = disk.of_diameter(k)[0].toarray()
    return np.einsum("n,nm,j,...jm->...", wave.shape.conj(), mass, turn, sectors)


def frequency_of(times, modal_motion):
    """Mean frequency [rad/s] of a exp(i Omega t), and the mean |a|."""
    angle = np.unwrap(np.angle(modal_motion))
    return np.polyfit(times, angle, 1)[0], np.abs(modal_motion).mean()
