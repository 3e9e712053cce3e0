"""Newmark's method on Jenkins contacts, a hand-written loop: newmark.c."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from benchmarks.peers.library import library
from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.laws.elements import per_contact


class Newmark:
    """A dense structure on its modes with free contacts, which must diagonalise its damping."""

    def __init__(self, structure: rom.Structure, law: rom.Jenkins) -> None:
        self._modes = ModalCoordinates.of(structure)
        if self._modes.damping.ndim != 1:
            raise rom.SlipmodeError("damping couples modes: Newmark's loop needs modal damping")
        self._limit = per_contact("limit", law.limit, structure.n_contacts)
        self._stiffness = per_contact("stiffness", law.stiffness, structure.n_contacts)

    def run(
        self,
        pattern: Floats,
        frequency: float,
        outputs: Floats,
        step: float,
        samples: int,
        every: int,
    ) -> tuple[Floats, Floats]:
        """Run from rest under pattern cos(frequency t), `samples` times `every` steps [s].

        Parameters
        ----------
        pattern : (n,) ndarray
            [N]
        outputs : (outputs, n) ndarray
            Requested displacements, as rows.

        Returns
        -------
        (samples, outputs) ndarray, (samples, N_c) ndarray
            These displacements, and the displacements of the contacts [m].
        """
        modes = self._modes
        rows = kernel.contiguous(outputs @ modes.shapes)
        modal = kernel.contiguous(pattern @ modes.shapes)
        x, x_c = np.empty((samples, len(rows))), np.empty((samples, len(self._limit)))
        response = modes.directions / (modes.squares + 2.0 / step * modes.damping + 4.0 / step**2)
        D = response @ modes.directions.T
        stuck = np.eye(len(D)) + self._stiffness[:, np.newaxis] * D
        R = kernel.contiguous(scipy.linalg.solve(stuck.T, D).T)
        status = library().peer_newmark(
            *(modes.squares.size, self._limit.size, modes.squares.ctypes.data),
            *(modes.damping.ctypes.data, modes.directions.ctypes.data, modal.ctypes.data),
            *(frequency, self._limit.ctypes.data, self._stiffness.ctypes.data),
            *(R.ctypes.data, step, samples, every),
            *(len(rows), rows.ctypes.data, x.ctypes.data, x_c.ctypes.data),
        )
        kernel.check(status, "Newmark's method")
        return x, x_c
