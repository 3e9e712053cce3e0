"""The least cost of marching two tanh contacts, by bare_contacts.c."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence

import numpy as np

from benchmarks.peers.library import library
from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.reduction.combination import Order

_LANES = 16  # SM_LANES of the core
_CONTACTS = 2


def bare_march(
    reduced: rom.Reduced,
    law: rom.Tanh,
    amplitude: Sequence[float],
    orders: Sequence[Order],
    steps: int,
    count: int,
) -> tuple[float, Floats]:
    """March `count` steps from rest under forcing at the carriers; lanes are phases of mode B.

    Parameters
    ----------
    reduced : Reduced
        Of two modes and two contacts.
    amplitude : (2,) sequence of float
        |a_A|, |a_B|.
    orders : sequence of (n, m)
        Harmonics of the sums; the carriers first.
    steps : int
        Per period of mode A, after which the forcing repeats.

    Returns
    -------
    float
        Processor time for each contact, stage and lane [s].
    (orders, N_c, 2, lanes) ndarray
        Real and imaginary part of x exp(-i nu t), summed over the steps [m].
    """
    problem = contact_problem(reduced, law)
    h = 2.0 * np.pi / (reduced.carrier[0] * steps)
    stages = h * (np.arange(steps)[:, np.newaxis] + (2.0 - np.sqrt(2.0), 1.0))
    phasor = np.exp(1j * stages[..., np.newaxis] * (np.array(orders) @ reduced.carrier))
    phases = np.exp(2j * np.pi * np.arange(_LANES) / _LANES)
    reaction = np.zeros((len(orders), _CONTACTS, 2, _LANES))
    for j, each in enumerate((np.ones(_LANES), phases)):
        force = -2.0 * amplitude[j] * reduced.coupling[j][:, np.newaxis] * each
        reaction[j] = np.stack((force.real, force.imag), axis=1)
    sums, x = np.zeros_like(reaction), np.zeros((_CONTACTS, _LANES))
    started = time.process_time()
    status = library().peer_bare_contacts(
        *(ctypes.byref(problem), h, count, steps, len(orders)),
        *(phasor.ctypes.data, reaction.ctypes.data, sums.ctypes.data, x.ctypes.data),
    )
    seconds = time.process_time() - started
    kernel.check(status, "bare contacts")
    return seconds / (count * 2 * _LANES * _CONTACTS), sums
