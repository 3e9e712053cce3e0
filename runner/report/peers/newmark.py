"""Newmark's method on Jenkins contacts, by newmark.c: what a hand-written loop takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.linalg

from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.laws.elements import per_contact
from slipmode.runner.report.peers.library import library


@dataclass(frozen=True, eq=False)
class Newmark:
    """A dense structure on the modes that it has with free contacts.

    Attributes
    ----------
    shapes : (n, n) ndarray
    squares, damping : (n,) ndarray
    directions : (N_c, n) ndarray
    limit, stiffness : (N_c,) ndarray
    """

    shapes: Floats
    squares: Floats
    damping: Floats
    directions: Floats
    limit: Floats
    stiffness: Floats

    @classmethod
    def of(cls, structure: rom.Structure, law: rom.Jenkins) -> Self:
        """Of a structure whose modes diagonalise its damping."""
        coordinates = ModalCoordinates.of(structure)
        if coordinates.damping.ndim != 1:
            raise rom.SlipmodeError("damping: must be that of modes, or none, for Newmark's loop")
        return cls(
            coordinates.shapes,
            coordinates.squares,
            coordinates.damping,
            coordinates.directions,
            per_contact("limit", law.limit, structure.n_contacts),
            per_contact("stiffness", law.stiffness, structure.n_contacts),
        )

    def run(
        self,
        pattern: Floats,
        frequency: float,
        outputs: Floats,
        step: float,
        samples: int,
        every: int,
    ) -> tuple[Floats, Floats]:
        """From rest under pattern cos(frequency t), `samples` times `every` steps [s].

        Parameters
        ----------
        pattern : (n,) ndarray
            [N]
        outputs : (outputs, n) ndarray
            Displacements that are wanted, as rows.

        Returns
        -------
        (samples, outputs) ndarray, (samples, N_c) ndarray
            These displacements, and those of the contacts [m].
        """
        rows = kernel.contiguous(outputs @ self.shapes)
        modal = kernel.contiguous(pattern @ self.shapes)
        x, x_c = np.empty((samples, len(rows))), np.empty((samples, len(self.limit)))
        damping = 2.0 / step * self.damping
        response = self.directions / (self.squares + damping + 4.0 / step**2)
        D = response @ self.directions.T
        held = np.eye(len(D)) + self.stiffness[:, np.newaxis] * D
        R = kernel.contiguous(scipy.linalg.solve(held.T, D).T)
        status = library().peer_newmark(
            *(self.squares.size, self.limit.size, self.squares.ctypes.data),
            *(self.damping.ctypes.data, self.directions.ctypes.data, modal.ctypes.data),
            *(frequency, self.limit.ctypes.data, self.stiffness.ctypes.data, R.ctypes.data, step),
            *(samples, every, len(rows), rows.ctypes.data, x.ctypes.data, x_c.ctypes.data),
        )
        kernel.check(status, "Newmark's method")
        return x, x_c
