"""The paper's scheme for the contact problem, Eq. (31), as printed; the loop is paper_scheme.c."""

from __future__ import annotations

import ctypes

import numpy as np

from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.problem import contact_problem
from slipmode.runner.report.peers.library import library


def paper_scheme(
    reduced: rom.Reduced, law: rom.Tanh, amplitudes: Floats, steps: int, *, corner: bool = True
) -> Complexes:
    """Friction functions Q_j (points, 2) from the second period of each time variable.

    Parameters
    ----------
    reduced : Reduced
        Of two modes, in the paper's formulation.
    amplitudes : (points, 2) ndarray
        |a_A|, |a_B| > 0.
    steps : int
        Grid points per period of t_A and of t_B.
    corner : bool
        Start from x_c = 0 at t_A = t_B = 0 alone, as printed, or on both axes.
    """
    points, rates = kernel.contiguous(amplitudes), kernel.contiguous(reduced.carrier)
    problem = contact_problem(reduced, law)
    P = np.empty((len(points), 2, reduced.n_contacts), dtype=complex)
    status = library().peer_paper_scheme(
        *(ctypes.byref(problem), rates.ctypes.data, steps, corner),
        *(len(points), points.ctypes.data, P.ctypes.data),
    )
    kernel.check(status, "scheme (31)")
    Q: Complexes = -np.einsum("jc,pjc->pj", reduced.coupling, P) / points
    return Q
