"""What the forces that hold the modes steady do to the contacts past their own mode.

In a steady state the force on mode j follows from its amplitude: with effective amplitudes
c_j = a_j + shift_j F_j and what the contacts do to the mode, -L_j^T P_j,

    F_j (1 + 2 shift_j D_j) = 2 (D_j c_j + L_j^T P_j),
    D_j = omega_j^2 - Omega_j^2 + i gamma_j Omega_j  at the carrier.

Of the force on the contacts that `off_resonance_shift` leaves over, residual_j F_j
/ 2, the contact problem thus knows all: it changes the coupling L_j, and what comes back from P_j.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.reduction.force_response import force_on_contacts, off_resonance_shift
from slipmode.rom.reduction.reduced import Reduced

_MOST_ASIDE = 0.5  # of the force on the contacts through the mode


def steady_force(reduced: Reduced) -> tuple[Complexes, Complexes]:
    """Force on the contacts per dynamic stiffness force D_j c_j + L_j^T P_j, and D_j.

    Returns
    -------
    (modes, N_c) complex ndarray
        0 where the reduction knows no `force_patterns`, and for a mode whose force moves the
        contacts past it about as much as through it: its amplitude does not tell the force then.
    (modes,) complex ndarray
        With the damping that comes back from other modes [rad^2/s^2].
    """
    modes = np.arange(len(reduced.modes))
    D = np.array(
        [reduced.modal_stiffness(nu)[j, j] for j, nu in zip(modes, reduced.carrier, strict=True)]
    )
    D = D + reduced.indirect_damping
    if reduced.force_patterns is None:
        return np.zeros_like(reduced.coupling), D
    shift = off_resonance_shift(reduced, list(reduced.force_patterns))[:, np.newaxis]
    residual = np.array(
        [force_on_contacts(reduced, j, f) for j, f in enumerate(reduced.force_patterns)]
    )
    residual += 2.0 * shift * reduced.coupling
    force = residual / (1.0 + 2.0 * shift * D[:, np.newaxis])
    aside, through = (
        np.linalg.norm(part, axis=1) for part in (D[:, np.newaxis] * force, reduced.coupling)
    )
    return np.where((aside <= _MOST_ASIDE * through)[:, np.newaxis], force, 0.0), D


def steady_coupling(reduced: Reduced) -> Complexes:
    """L_j of a mode that its force holds steady, (modes, N_c)."""
    force, D = steady_force(reduced)
    return np.asarray(reduced.coupling - D[:, np.newaxis] * force)


def steady_reaction(reduced: Reduced) -> Complexes:
    """Force on the contacts per carrier P_j (modes, N_c, N_c), by the force that answers it."""
    force, _ = steady_force(reduced)
    return np.asarray(np.einsum("jc,jd->jcd", force, reduced.coupling))
