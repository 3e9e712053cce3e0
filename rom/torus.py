"""The contact problem on the torus, Eqs. (13), (14), (20), by characteristics."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rom import _kernel
from rom.errors import SlipmodeError
from rom.friction import Friction, limits
from rom.matrices import Floats
from rom.reduction import Reduced

_MAX_PERIODS = 400


@dataclass(frozen=True)
class Discretisation:
    """How finely the torus is resolved.

    Attributes
    ----------
    steps : int
        Time steps per period of mode A.
    lines : int
        Phase lines of mode B, a power of two; 1 for a one-mode model.
    """

    steps: int
    lines: int


@dataclass(frozen=True, eq=False)
class ContactHarmonics:
    """Periodic contact motion at several amplitudes.

    Attributes
    ----------
    P : (points, orders, N_c) complex ndarray
        Fourier coefficients of the contact displacement [m], Eq. (14).
    residual : (points,) ndarray
        Estimated distance from periodicity, relative to the frictionless displacement.
    periods : (points,) ndarray of int
        Periods of mode A that were marched.
    """

    P: NDArray[np.complex128]
    residual: Floats
    periods: NDArray[np.int32]


def contact_problem(reduced: Reduced, law: Friction) -> _kernel.Contact:
    """The contact problem as the core reads it."""
    return _kernel.contact(
        _kernel.contiguous(reduced.stiffness),
        _kernel.contiguous(reduced.damping),
        np.ascontiguousarray(reduced.coupling),
        limits(law, reduced.n_contacts),
        law.code,
        law.alpha,
    )


def contact_harmonics(
    reduced: Reduced,
    law: Friction,
    amplitudes: ArrayLike,
    grid: Discretisation,
    orders: Sequence[tuple[int, int]] = ((1, 0), (0, 1)),
    tolerance: float = 1e-5,
    smallest_scale: ArrayLike = (0.0, 0.0),
) -> ContactHarmonics:
    """Solve Eq. (13) for the periodic contact motion.

    Parameters
    ----------
    amplitudes : (points, modes) array_like
        Modal amplitudes |a_j| [kg^1/2 m], >= 0.
    orders : sequence of (n, m)
        Harmonics P_nm to compute.
    tolerance : float
        The march ends when the harmonics repeat to this fraction of the frictionless contact
        displacement at the point's amplitudes.
    smallest_scale : (modes,) array_like
        Amplitudes whose frictionless displacement is the scale instead where it is larger.

    Notes
    -----
    Marched at the natural frequencies along t_B = t_B0 + (omega_B / omega_A) t_A with an
    L-stable second-order rule; second order in `steps`, spectral in `lines`.
    """
    points = _kernel.contiguous(amplitudes)
    if points.ndim != 2 or points.shape[1] != len(reduced.modes):
        raise SlipmodeError(f"amplitudes: must have shape (points, {len(reduced.modes)})")
    orders_array = np.ascontiguousarray(orders, dtype=np.int32)
    rates = _kernel.contiguous(reduced.frequency)
    smallest = _kernel.contiguous(smallest_scale)
    problem = contact_problem(reduced, law)
    P = np.empty((len(points), len(orders_array), reduced.n_contacts), dtype=complex)
    residual = np.empty(len(points))
    periods = np.empty(len(points), dtype=np.int32)
    status = _kernel.lib.sm_torus_harmonics(
        ctypes.byref(problem),
        *(
            rates.ctypes.data,
            grid.steps,
            grid.lines,
            tolerance,
            smallest.ctypes.data,
            _MAX_PERIODS,
        ),
        *(len(points), points.ctypes.data, len(orders_array), orders_array.ctypes.data),
        *(P.ctypes.data, residual.ctypes.data, periods.ctypes.data),
    )
    _kernel.check(status, "contact problem on the torus")
    return ContactHarmonics(P, residual, periods)


def friction_terms(
    reduced: Reduced,
    law: Friction,
    amplitudes: ArrayLike,
    grid: Discretisation,
    tolerance: float = 1e-5,
    smallest_scale: ArrayLike = (0.0, 0.0),
) -> tuple[NDArray[np.complex128], Floats]:
    """S_j = Q_j |a_j| of every mode, Eq. (20), and the distance from periodicity.

    Returns
    -------
    S : (points, modes) complex ndarray
        [N kg^-1/2]. Exactly 0 where |a_j| = 0.
    residual : (points,) ndarray
    """
    orders = ((1, 0), (0, 1))[: len(reduced.modes)]
    solved = contact_harmonics(reduced, law, amplitudes, grid, orders, tolerance, smallest_scale)
    S = -np.einsum("jc,pjc->pj", reduced.coupling, solved.P)
    S[np.asarray(amplitudes) == 0.0] = 0.0
    return S, solved.residual


def friction_functions(
    reduced: Reduced,
    law: Friction,
    amplitudes: ArrayLike,
    grid: Discretisation,
    tolerance: float = 1e-5,
) -> NDArray[np.complex128]:
    """The complex friction functions Q_j of Eq. (20), (points, modes), for amplitudes > 0."""
    S, _ = friction_terms(reduced, law, amplitudes, grid, tolerance)
    Q: NDArray[np.complex128] = S / np.asarray(amplitudes, dtype=float)
    return Q
