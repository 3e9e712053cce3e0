"""The source paper's scheme for the contact problem, Eq. (31), by paper_scheme.c."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.peers.library import library
from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes
from slipmode.rom.contact.torus.march import contact_problem


def paper_scheme(
    reduced: rom.Reduced,
    law: rom.Tanh,
    amplitudes: ArrayLike,
    steps: int,
    *,
    corner: bool,
    periods: int = 2,
) -> Complexes:
    """Return the friction functions Q_j (points, 2) of the last period in t_A and in t_B.

    Parameters
    ----------
    reduced : Reduced
        Of two modes, in the paper's formulation.
    amplitudes : (points, 2) array_like
        |a_A|, |a_B| > 0.
    steps : int
        Grid points per period of t_A and of t_B.
    corner : bool
        Start from x_c = 0 at t_A = t_B = 0 alone, as printed, or on both axes.
    periods : int
        Of t_A and of t_B; the paper takes two.
    """
    points = kernel.contiguous(np.asarray(amplitudes, dtype=float))
    rates = kernel.contiguous(reduced.carrier)
    problem = contact_problem(reduced, law)
    P = np.empty((len(points), 2, reduced.n_contacts), dtype=complex)
    status = library().peer_paper_scheme(
        *(ctypes.byref(problem), rates.ctypes.data, steps, periods, corner),
        *(len(points), points.ctypes.data, P.ctypes.data),
    )
    kernel.check(status, "scheme (31)")
    Q: Complexes = -np.einsum("jc,pjc->pj", reduced.coupling, P) / points
    return Q
