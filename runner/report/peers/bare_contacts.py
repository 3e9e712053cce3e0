"""The least that marching two tanh contacts costs, by bare_contacts.c: a floor for our tables."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.torus.problem import contact_problem
from slipmode.rom.reduction.combination import Order
from slipmode.runner.report.peers.library import library

_LANES = 16
_CONTACTS = 2


@dataclass(frozen=True, eq=False)
class BareMarch:
    """From rest through some steps.

    Attributes
    ----------
    seconds : float
        Of the processor, for each contact, stage and lane.
    sums : (orders, N_c, 2, lanes) ndarray
        Real and imaginary part of x exp(-i nu t), summed over the steps [m].
    """

    seconds: float
    sums: Floats


def bare_march(
    reduced: rom.Reduced,
    law: rom.Tanh,
    amplitude: Sequence[float],
    orders: Sequence[Order],
    steps: int,
    count: int,
) -> BareMarch:
    """March `count` steps under the forcing at the carriers; the lanes are phases of mode B.

    Parameters
    ----------
    reduced : Reduced
        Of two modes and two contacts.
    amplitude : (2,) sequence of float
        |a_A|, |a_B|.
    orders : sequence of (n, m)
        Harmonics that are summed, and of which the forcing consists; the carriers first.
    steps : int
        Per period of mode A, after which the forcing repeats.
    """
    problem = contact_problem(reduced, law)
    h = 2.0 * np.pi / (reduced.carrier[0] * steps)
    stages = h * (np.arange(steps)[:, np.newaxis] + (1.0 - np.sqrt(0.5), 1.0))
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
    return BareMarch(seconds / (count * 2 * _LANES * _CONTACTS), sums)
