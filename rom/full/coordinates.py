"""Coordinates in which the linear part of a time step costs O(n): the modes of (M, K)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.linalg

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.elements import address
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.matrices import as_dense
from slipmode.rom.structure.structure import Structure

_GAMMA = 0.25  # SM_FULL_GAMMA
_ELASTIC = 2  # SM_ELASTIC
_ROUNDING = 1e-12  # of a squared natural frequency, relative to the largest
_UNCOUPLED = 1e-9  # largest damping between two modes, relative to their own, that is rounding


@dataclass(frozen=True, eq=False)
class ModalCoordinates:
    """x = shapes q: the identity as mass, a diagonal stiffness.

    Attributes
    ----------
    shapes : (n, n) ndarray
        Modes with free contacts, mass-normalised columns [kg^-1/2].
    squares : (n,) ndarray
        Squared natural frequencies [rad^2/s^2]; 0 of rigid-body modes, to rounding.
    damping : (n,) or (n, n) ndarray
        [1/s]; (n,) if the modes diagonalise it.
    directions : (N_c, n) ndarray
        Contact displacement per modal displacement, W^T shapes.
    to_modal : (n, n) ndarray
        q = to_modal x.
    """

    shapes: Floats
    squares: Floats
    damping: Floats
    directions: Floats
    to_modal: Floats

    __repr__ = short_repr

    @classmethod
    def of(cls, structure: Structure) -> Self:
        """The modes of a structure, damping diagonal wherever it can be."""
        mass = as_dense(structure.mass)
        squares, shapes = scipy.linalg.eigh(as_dense(structure.stiffness), mass)
        rounding = _ROUNDING * squares.max()
        squares[(squares < 0) & (squares > -rounding)] = 0.0  # rigid-body modes
        if structure.beta is not None:
            damping = structure.beta * squares
        else:
            damping = _diagonal_if_possible(shapes.T @ as_dense(structure.damping @ shapes))
        return cls(
            shapes=shapes,
            squares=squares,
            damping=damping,
            directions=kernel.contiguous(structure.directions.T @ shapes),
            to_modal=shapes.T @ mass,
        )

    def inverse(self, step: float) -> Floats:
        """A^-1 with A = I / (gamma h) + C + gamma h K, in the shape of the damping."""
        diagonal = 1.0 / (_GAMMA * step) + _GAMMA * step * self.squares
        if self.damping.ndim == 1:
            return np.asarray(1.0 / (diagonal + self.damping))
        inverse = scipy.linalg.inv(np.diag(diagonal) + self.damping)
        return np.asarray(0.5 * (inverse + inverse.T))

    def compliance(self, inverse: Floats) -> Floats:
        """W^T A^-1 W: velocity of the contacts per unit of force on them."""
        W = self.directions.T
        response = inverse[:, np.newaxis] * W if inverse.ndim == 1 else inverse @ W
        return np.asarray(W.T @ response)

    def resistance(self, inverse: Floats) -> Floats:
        """S = (W^T A^-1 W)^-1: force on the contacts per unit of velocity it takes away."""
        S = scipy.linalg.inv(self.compliance(inverse))
        return np.asarray(0.5 * (S + S.T))

    def flexibility(self, inverse: Floats, step: float, reference: Floats) -> Floats:
        """R = D (I + k_ref D)^-1, D = gamma h W^T A^-1 W: of a stage with stuck contacts."""
        D = _GAMMA * step * self.compliance(inverse)
        held = np.eye(len(D)) + reference[:, np.newaxis] * D
        R = scipy.linalg.solve(held.T, D).T
        return np.asarray(0.5 * (R + R.T))

    def kernel(
        self, law: Friction | Elastic, patterns: Floats, output: Floats, step: float
    ) -> kernel.Full:
        """The problem as the core reads it, for one size of the time step.

        Parameters
        ----------
        patterns : (modes, n) ndarray
            Forces on the DOFs of the structure.
        output : (outputs, n) ndarray
            Displacements wanted, as rows that act on the DOFs of the structure.
        """
        inverse, contacts = self.inverse(step), len(self.directions)
        elastic, code, alpha = None, _ELASTIC, 0.0
        if isinstance(law, Elastic):
            elements = law.elements(contacts)
            elastic = elements.kernel()
            of_law = {"flexibility": self.flexibility(inverse, step, elements.reference)}
        else:
            code, alpha = law.code, law.alpha
            of_law = {"limit": limits(law, contacts), "resistance": self.resistance(inverse)}
        arrays = of_law | {
            "stiffness": self.squares,
            "damping": self.damping,
            "directions": self.directions,
            "patterns": patterns @ self.shapes,
            "output": output @ self.shapes,
            "inverse": inverse,
        }
        arrays = {name: kernel.contiguous(array) for name, array in arrays.items()}
        full = kernel.Full(
            coordinates=self.squares.size,
            contacts=contacts,
            modes=len(patterns),
            outputs=len(output),
            law=code,
            diagonal=int(self.damping.ndim == 1),
            alpha=alpha,
            step=step,
            elastic=address(elastic),
            **{name: array.ctypes.data for name, array in arrays.items()},
        )
        full.owned = (arrays, elastic)
        return full


def _diagonal_if_possible(damping: Floats) -> Floats:
    """The diagonal (n,) of a matrix that couples no modes beyond rounding, else the matrix."""
    own = np.sqrt(np.abs(np.diag(damping)))
    coupling = np.abs(damping - np.diag(np.diag(damping)))
    if np.all(coupling <= _UNCOUPLED * np.outer(own, own)):
        return np.diag(damping).copy()
    return 0.5 * (damping + damping.T)
