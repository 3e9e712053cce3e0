"""Fixed-interface modes: natural modes of the structure with its contacts bonded."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.matrices import Matrix, as_dense
from slipmode.rom.structure.partition import Partition

_DENSE_SIZE = 500  # up to here a dense eigenvalue problem is the faster one

_RIGID = (
    "stiffness: must be positive definite with bonded contacts, but the structure has a "
    "rigid-body mode then; fix a DOF or add a contact"
)


_FIRST_COUNT, _MOST = 16, 128  # modes computed at first, and at most, to pass a frequency


def modes_below(parts: Partition, frequency: float, at_least: int) -> tuple[Floats, Floats]:
    """Modes below a frequency [rad/s], but no fewer than asked for, and 128 at most."""
    size = parts.K_ec.shape[0]
    count = min(max(_FIRST_COUNT, at_least), size)
    while True:
        omega, phi = fixed_interface_modes(parts, count)
        if omega[-1] >= frequency or count >= min(_MOST, size):
            break
        count = min(2 * count, size)
    kept = max(int(np.searchsorted(omega, frequency)), at_least)
    return omega[:kept], phi[:, :kept]


def fixed_interface_modes(parts: Partition, count: int) -> tuple[Floats, Floats]:
    """Lowest natural frequencies (count,) and modes (n_e, count) with bonded contacts, Eq. (8).

    Mass-normalised; the largest component of each mode is positive.
    """
    try:
        squares, phi = lowest_modes(parts.K_ee, parts.M_ee, count)
    except RuntimeError as error:
        raise SlipmodeError(_RIGID) from error
    stiffest = parts.K_ee.diagonal().max() / parts.M_ee.diagonal().max()
    if squares[0] <= 1e-12 * stiffest:
        raise SlipmodeError(_RIGID)
    return np.sqrt(squares), phi


def lowest_modes(K: Matrix, M: Matrix, count: int, shift: float = 0.0) -> tuple[Floats, Floats]:
    """Lowest omega^2 (count,) and modes (n, count) of (K, M), mass-normalised.

    The largest component of each mode is positive.

    Raises
    ------
    RuntimeError
        If a sparse K - shift M is singular.
    """
    size = K.shape[0]
    if not scipy.sparse.issparse(K) or size <= _DENSE_SIZE or count >= size - 1:
        squares, phi = scipy.linalg.eigh(as_dense(K), as_dense(M), subset_by_index=(0, count - 1))
    else:
        from scipy.sparse.linalg import eigsh  # takes a while to import

        squares, phi = eigsh(K, k=count, M=M, sigma=shift, v0=np.ones(size))
    phi = phi * np.sign(phi[np.argmax(np.abs(phi), axis=0), np.arange(count)])
    return squares, phi
