"""The rate correction: how far friction is behind that of steady motion while amplitudes grow.

A contact that sticks holds what the last reversal left, and that was as large as the amplitude
was then. To first order in the growth, S_j = S_j(|a|) + sum_k R_jk(|a|) d|a_k|/dt; where
contacts slip all the time R is 0. It is a hundredth of S_j in a fast transient.

Elastic contacts have it in the terms of their dual problem: they hold what they lacked in force
at the last reversal.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.reduced import Reduced


def friction_rate_correction(
    reduced: Reduced,
    law: Friction,
    amplitudes: Floats,
    amplitude_range: Floats,
    grid: Discretisation,
) -> Complexes:
    """dS_j / d(d|a_k|/dt) [N kg^-1 s/m], (points, modes, modes) by j and k.

    Parameters
    ----------
    amplitudes : (points, modes) ndarray
        Modal amplitudes |a_j| [kg^1/2 m], >= 0.
    amplitude_range : (modes,) ndarray
        Of the table: the scale of the growth where an amplitude is small.
    grid : Discretisation
    """
    modes = amplitude_range.size
    # in a period of mode A: small against the amplitude, large against rounding
    growth = np.maximum(0.02 * amplitudes, 0.002 * amplitude_range)
    # of one mode after the other, up and down
    along = np.array([[1.0], [-1.0]]) * np.eye(modes)[:, np.newaxis]
    growing = kernel.contiguous(along[:, :, np.newaxis] * growth)
    passed = kernel.contiguous(np.broadcast_to(amplitudes, growing.shape))
    problem = contact_problem(reduced, law)
    problem.response = None
    orders = np.array(CARRIERS[:modes], dtype=np.int32)
    discretised = kernel.Discretisation(
        rates=kernel.contiguous(reduced.carrier),
        steps=grid.steps,
        lines=grid.lines,
        orders_count=modes,
        orders=orders,
    )
    P = np.empty((*growing.shape, reduced.n_contacts), dtype=complex)
    status = kernel.lib.sm_torus_growing(
        problem, discretised, growing.size // modes, passed, growing, P
    )
    kernel.check(status, "contact problem of growing amplitudes")
    S = -np.einsum("jc,...jc->...j", reduced.coupling, P)
    rate_correction = np.moveaxis(S[:, 0] - S[:, 1], 0, -1) / (2.0 * growth[:, np.newaxis])
    rate_correction *= 2.0 * np.pi / reduced.carrier[0]
    # of one mode by the growth of the other: odd in both amplitudes
    of_other = ~np.eye(modes, dtype=bool)
    rate_correction[(amplitudes == 0.0).any(axis=1)[:, np.newaxis, np.newaxis] & of_other] = 0.0
    return np.asarray(rate_correction)
