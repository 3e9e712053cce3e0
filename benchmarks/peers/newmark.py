"""Newmark's method on Jenkins contacts, a hand-written loop: newmark.c."""

from __future__ import annotations

import ctypes

import numpy as np
import scipy.linalg

from benchmarks.peers.library import library
from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.laws.elements import per_contact

_BLOCK = 4  # BLOCK of newmark.c
_ARRAYS = "gather response flexibility limit stiffness of_q of_v of_a of_force q v a moved"
_CONTACT_STATE = ("x", "u", "y", "slider", "slips")


class _Record(ctypes.Structure):
    """peer_newmark_record."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("contacts", "width")),
        *((name, ctypes.c_double) for name in ("step", "frequency")),
        *(
            (name, ctypes.c_void_p)
            for name in (*_ARRAYS.split(), *_CONTACT_STATE, "matrix", "right", "active")
        ),
    )


def newmark(
    modes: ModalCoordinates,
    law: rom.Jenkins,
    pattern: Floats,
    frequency: float,
    step: float,
    samples: int,
    every: int,
) -> Floats:
    """Run from rest under pattern cos(frequency t), `samples` times `every` steps [s].

    Parameters
    ----------
    modes : ModalCoordinates
        Of the structure; they must diagonalise its damping.
    pattern : (n,) ndarray
        [N]

    Returns
    -------
    (samples, N_c) ndarray
        Displacements of the contacts [m].
    """
    contacts = len(modes.directions)
    if modes.damping.ndim != 1:
        raise rom.SlipmodeError("damping couples modes: Newmark's loop needs modal damping")
    limit = per_contact("limit", law.limit, contacts)
    k = per_contact("stiffness", law.stiffness, contacts)
    c, force = modes.damping, pattern @ modes.shapes
    inverse = 1.0 / (modes.squares + 2.0 * c / step + 4.0 / step**2)
    response = modes.directions * inverse
    D = response @ modes.directions.T
    R = scipy.linalg.solve((np.eye(contacts) + k[:, np.newaxis] * D).T, D).T
    width = -(-c.size // _BLOCK) * _BLOCK
    by_mode = {
        "gather": (np.eye(contacts) - R * k) @ modes.directions,
        "response": response,
        "of_q": inverse * (4.0 / step**2 + 2.0 * c / step),
        "of_v": inverse * (4.0 / step + c),
        "of_a": inverse,
        "of_force": inverse * force,
        "a": force,
        **dict.fromkeys(("q", "v", "moved"), 0.0 * force),
    }
    padding = (0, width - c.size)
    arrays = {
        name: np.pad(array, [(0, 0)] * (array.ndim - 1) + [padding])
        for name, array in by_mode.items()
    }
    arrays |= {name: np.zeros(contacts) for name in (*_CONTACT_STATE, "right", "active")}
    arrays |= {"flexibility": R, "limit": limit, "stiffness": k, "matrix": 0.0 * R}
    arrays = {name: kernel.contiguous(array) for name, array in arrays.items()}
    pointers = {name: array.ctypes.data for name, array in arrays.items()}
    record = _Record(contacts, width, step, frequency, **pointers)
    x_c = np.empty((samples, contacts))
    status = library().peer_newmark(ctypes.byref(record), samples, every, x_c.ctypes.data)
    kernel.check(status, "Newmark's method")
    return x_c
