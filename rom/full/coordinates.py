"""Modal coordinates of (M, K), in which the linear part of a time step costs O(n)."""

from __future__ import annotations

from typing import Self

import numpy as np
import scipy

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import as_dense
from slipmode.rom.structure.solvers.lowest_modes import dense_modes
from slipmode.rom.structure.structure import Structure

_ROUNDING = 1e-12  # squared natural frequency that is rounding, relative to the largest
# Frequency of motions without inertia, relative to the highest natural frequency. They follow
# statically, by backward Euler, except for (frequency * step)^-2 of their motion.
_STATIC = 1e6


@frozen
class ModalCoordinates:
    """Coordinates q, x = shapes q, with unit mass and diagonal stiffness.

    Motions without inertia are the last coordinates, with a very high frequency.
    """

    shapes: Floats  # (n, m), mass-normalised modes with free contacts in columns [kg^-1/2]
    squares: Floats  # (m,), squared natural frequencies [rad^2/s^2]
    damping: Floats  # (m,) if the modes diagonalise it, else (m, m) [1/s]
    directions: Floats  # (N_c, m), contact displacement per modal displacement, W^T shapes
    to_modal: Floats  # (m, n), q = to_modal x

    @classmethod
    def of(cls, structure: Structure, carriers: Floats) -> Self:
        """Return the modes of a structure, with diagonal damping if that is exact to rounding.

        Structural damping K'' becomes K'' / nu, with the frequency nu nearest to the mode among
        `carriers` (modes,) [rad/s].
        """
        mass = as_dense(structure.mass)
        K, Z = as_dense(structure.stiffness), as_dense(structure.massless)
        squares, shapes = dense_modes(K, mass, structure.massless)
        rounding = _ROUNDING * squares.max()
        squares[(squares < 0) & (squares > -rounding)] = 0.0  # rigid-body modes
        to_modal = shapes.T @ mass
        if Z.shape[1]:
            square = _STATIC**2 * float(squares.max())
            sizes, mixed = scipy.linalg.eigh(Z.T @ K @ Z)
            static = Z @ (mixed * np.sqrt(square / sizes))
            squares = np.append(squares, np.full(sizes.size, square))
            shapes = np.hstack((shapes, static))
            to_modal = np.vstack((to_modal, static.T @ K / square))
        if structure.beta is not None:
            damping = structure.beta * squares
        else:
            damping = _diagonal_if_possible(shapes.T @ as_dense(structure.damping @ shapes))
        if structure.loss is not None:
            nu = np.sqrt(_nearest(np.sqrt(np.maximum(squares, 0.0)), carriers))
            loss = shapes.T @ as_dense(structure.loss @ shapes) / np.outer(nu, nu)
            damping = np.diag(damping) if damping.ndim == 1 else damping
            damping = _diagonal_if_possible(damping + loss)
        return cls(
            shapes=shapes,
            squares=squares,
            damping=damping,
            directions=kernel.contiguous(structure.directions.T @ shapes),
            to_modal=to_modal,
        )

    def inverse(self, own: Floats | float) -> Floats:
        """Return A^-1, A = I / g + C + g K, in the shape of the damping; `own` is g [s]."""
        diagonal = 1.0 / own + own * self.squares
        if self.damping.ndim == 1:
            return np.asarray(1.0 / (diagonal + self.damping))
        inverse = scipy.linalg.inv(np.diag(diagonal) + self.damping)
        return np.asarray(0.5 * (inverse + inverse.T))

    def _response(self, inverse: Floats) -> Floats:
        """Return A^-1 W (n, N_c): modal velocity per unit of force on the contacts."""
        W = self.directions.T
        return np.asarray(inverse[:, np.newaxis] * W if inverse.ndim == 1 else inverse @ W)

    def resistance(self, inverse: Floats) -> Floats:
        """Return S = (W^T A^-1 W)^-1, force on the contacts per unit of their velocity."""
        S = scipy.linalg.inv(self.directions @ self._response(inverse))
        return np.asarray(0.5 * (S + S.T))

    def flexibility(self, inverse: Floats, own: Floats, reference: Floats) -> Floats:
        """Return R = D (I + k_ref D)^-1, D = W^T g A^-1 W, of a step with stuck contacts."""
        D = (self.directions * own) @ self._response(inverse)
        held = np.eye(len(D)) + reference[:, np.newaxis] * D
        return np.asarray(scipy.linalg.solve(held.T, D.T).T)

    def weights(self, step: float, carriers: Floats) -> tuple[Floats, Floats]:
        """Return weights g, b (n,) [s] of the rates at the end and at the start of a step.

        The trapezoidal rule changes a frequency Omega to 2 / h tan(Omega h / 2). A longer step of
        each mode (prewarping, as for filters) makes the rule exact at the carrier nearest to its
        frequency, so that resonances are exact but for harmonics. Modes that turn by more than 1
        rad in a step follow statically, by backward Euler, and do not ring. `carriers` (modes,)
        are the forcing frequencies [rad/s].
        """
        omega = np.sqrt(np.maximum(self.squares, 0.0))
        near = np.minimum(_nearest(omega, carriers), 1.0 / step)
        half = np.tan(0.5 * near * step) / near
        moves = omega * step <= 1.0
        return np.where(moves, half, step), np.where(moves, half, 0.0)

    def kernel(
        self,
        law: Friction | Elastic,
        patterns: Floats,
        output: Floats,
        step: float,
        carriers: Floats,
    ) -> kernel.Structure:
        """Return the problem as the core reads it, for one size of the time step.

        Forces have patterns (modes, n) and frequencies `carriers` (modes,) [rad/s]; outputs are
        rows (outputs, n) that combine the DOFs.
        """
        contacts = len(self.directions)
        elastic, code, alpha = None, 2, 0.0  # SM_ELASTIC of the core
        if isinstance(law, Elastic):
            elements = law.elements(contacts)
            elastic = elements.kernel()
            own, ahead = self.weights(step, carriers)
            inverse = self.inverse(own)
            flexibility = self.flexibility(inverse, own, elements.reference)
            of_law = {"own": own, "ahead": ahead, "flexibility": flexibility}
        else:
            code, alpha = law.code, law.alpha
            inverse = self.inverse(0.25 * step)  # SM_FULL_GAMMA of the core
            of_law = {"limit": limits(law, contacts), "resistance": self.resistance(inverse)}
        arrays = of_law | {
            "stiffness": self.squares,
            "damping": self.damping,
            "directions": self.directions,
            "patterns": patterns @ self.shapes,
            "output": output @ self.shapes,
            "inverse": inverse,
        }
        return kernel.Full(
            coordinates=self.squares.size,
            contacts=contacts,
            modes=len(patterns),
            outputs=len(output),
            law=code,
            diagonal=int(self.damping.ndim == 1),
            alpha=alpha,
            step=step,
            elastic=elastic,
            **{name: kernel.contiguous(array) for name, array in arrays.items()},
        )


def _nearest(omega: Floats, carriers: Floats) -> Floats:
    """Return the carrier nearest to each natural frequency, (m,) [rad/s]."""
    distance = np.abs(np.log(np.maximum(omega, _ROUNDING)[:, np.newaxis] / carriers))
    return np.asarray(carriers[distance.argmin(axis=1)])


def _diagonal_if_possible(damping: Floats) -> Floats:
    """Return the diagonal (n,) if it is the matrix but for rounding, else the matrix."""
    own = np.sqrt(np.abs(np.diag(damping)))
    coupling = np.abs(damping - np.diag(np.diag(damping)))
    if np.all(coupling <= 1e-9 * np.outer(own, own)):
        return np.diag(damping).copy()
    return 0.5 * (damping + damping.T)
