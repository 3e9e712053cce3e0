"""Newmark's method on Jenkins contacts, by newmark.c: what a hand-written loop takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.linalg

from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import per_contact
from slipmode.rom.structure.held import stuck_stiffness
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.peers.library import library


@dataclass(frozen=True, eq=False)
class Newmark:
    """A dense structure on the modes that it has while its contacts stick.

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
        """Of a structure whose damping its stuck modes diagonalise; the rest of it is left out."""
        limit = per_contact("limit", law.limit, structure.n_contacts)
        stiffness = per_contact("stiffness", law.stiffness, structure.n_contacts)
        held = as_dense(stuck_stiffness(structure, stiffness))
        squares, shapes = scipy.linalg.eigh(held, as_dense(structure.mass))
        damping = np.einsum("nk,nk->k", shapes, as_dense(structure.damping @ shapes))
        directions = kernel.contiguous(as_dense(structure.directions.T @ shapes))
        return cls(shapes, squares, damping, directions, limit, stiffness)

    def run(
        self, pattern: Floats, frequency: float, outputs: Floats, step: float, samples: int, every: int
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
        status = library().peer_newmark(
            *(self.squares.size, self.limit.size, self.squares.ctypes.data),
            *(self.damping.ctypes.data, self.directions.ctypes.data, modal.ctypes.data),
            *(frequency, self.limit.ctypes.data, self.stiffness.ctypes.data, step, samples, every),
            *(len(rows), rows.ctypes.data, x.ctypes.data, x_c.ctypes.data),
        )
        kernel.check(status, "Newmark's method")
        return x, x_c
