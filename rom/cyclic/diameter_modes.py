"""Modes of one nodal diameter with stuck contacts, and how its contacts respond to forces."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy.linalg

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.nonresonant import MOST_MODES
from slipmode.rom.short_repr import frozen

# DOFs up to which all modes of a dense matrix take less time than a few of a sparse one.
_DENSE = 400


@frozen
class SlowMode:
    """A mode with a slow flow at the frequency of its carrier.

    Dampers move the other modes with it, and the forces on these act on it through dampers:
    (stiffness + indirect) a = receiving^H (forces), u = shape a + response without the mode.

    Attributes
    ----------
    shape, receiving : (n_s,) complex ndarray
        [kg^-1/2]
    stiffness : complex
        D = omega^2 - Omega^2 + i gamma Omega [rad^2/s^2].
    indirect : complex
        Stiffness that returns from the other modes [rad^2/s^2].
    """

    shape: Complexes
    receiving: Complexes
    stiffness: complex
    indirect: complex


@frozen
class DiameterModes:
    """Modes of a nodal diameter k: sector j moves like exp(i k 2 pi j / N) times sector 0.

    Contacts are springs of the stiffness k_ref that they have in stick.

    Attributes
    ----------
    frequency : (modes,) ndarray
        omega [rad/s], ascending.
    shapes : (n_s, modes) complex ndarray
        At the free DOFs, phi^H M phi = 1 for one sector [kg^-1/2].
    damping : (modes, modes) complex ndarray
        phi^H C phi [1/s].
    contact_motion : (N_c, modes) complex ndarray
        Of sector 0 per modal amplitude [kg^-1/2].
    stiffness : (n_s, n_s) CSC matrix
        With the springs of the contacts [N/m].
    contacts : (N_c, n_s) CSC matrix
        `CyclicStructure.contact_motion`.
    """

    frequency: Floats
    shapes: Complexes
    damping: Complexes
    contact_motion: Complexes
    stiffness: Any
    contacts: Any

    @classmethod
    def of(
        cls, structure: CyclicStructure, nodal_diameter: int, reference: Floats, highest: float
    ) -> Self:
        """Return the modes of a nodal diameter.

        Parameters
        ----------
        structure : CyclicStructure
        nodal_diameter : int
        reference : (N_c,) ndarray
            k_ref [N/m].
        highest : float
            Frequency up to which modes respond with their inertia [rad/s].
        """
        M, C, K = structure.of_diameter(nodal_diameter)
        W = structure.contact_motion(nodal_diameter)
        held = (K + W.conj().T @ (reference[:, np.newaxis] * W)).tocsc()
        omega, shapes = _lowest(held, M, highest)
        return cls(omega, shapes, shapes.conj().T @ (C @ shapes), W @ shapes, held, W)

    @cached_property
    def _factors(self) -> Any:
        from scipy.sparse.linalg import splu  # takes long to import

        return splu(self.stiffness.astype(complex))

    def response(
        self, force: Complexes, frequency: float, without: int | None = None
    ) -> Complexes:
        """Return displacements (n_s, forces) by forces (n_s, forces) at a frequency [rad/s].

        The modes respond with their inertia, all others statically. `without` is a mode that is
        left out, because it has a slow flow.
        """
        kept, stiffness = self._others(frequency, without)
        modal = np.linalg.solve(stiffness, self.shapes[:, kept].conj().T @ force)
        return np.asarray(self.shapes[:, kept] @ modal + self.past_modes(force))

    def past_modes(self, force: Complexes) -> Complexes:
        """Return static displacements (n_s, forces) besides those of the modes."""
        static = self._factors.solve(np.ascontiguousarray(force, dtype=complex))
        on_modes = self.shapes.conj().T @ force
        return np.asarray(static - self.shapes @ (on_modes / self.frequency[:, np.newaxis] ** 2))

    def slow_mode(self, mode: int, frequency: float) -> SlowMode:
        """Return a mode and what the others do with it, by dampers, at a frequency [rad/s]."""
        kept, stiffness = self._others(frequency, mode)
        dampers = 1j * frequency * self.damping
        moved = -np.linalg.solve(stiffness, dampers[kept, mode])
        returned = -np.linalg.solve(stiffness.T, dampers[mode, kept])
        others, own = self.shapes[:, kept], self.shapes[:, mode]
        return SlowMode(
            shape=own + others @ moved,
            receiving=own + others @ returned.conj(),
            stiffness=complex(self.frequency[mode] ** 2 - frequency**2 + dampers[mode, mode]),
            indirect=complex(dampers[mode, kept] @ moved),
        )

    def _others(self, frequency: float, without: int | None) -> tuple[Flags, Complexes]:
        """Return which modes respond, and their dynamic stiffness at a frequency."""
        kept = np.arange(self.frequency.size) != (-1 if without is None else without)
        stiffness = np.diag(self.frequency**2 - frequency**2) + 1j * frequency * self.damping
        return kept, stiffness[np.ix_(kept, kept)]

    def flexibility(self, frequency: float, without: int | None = None) -> Complexes:
        """Return contact displacements of sector 0 per force on its contacts, (N_c, N_c)."""
        kept, stiffness = self._others(frequency, without)
        psi = self.contact_motion[:, kept]
        return np.asarray(psi @ np.linalg.solve(stiffness, psi.conj().T) + self.past_flexibility)

    @cached_property
    def past_flexibility(self) -> Complexes:
        """Static flexibility of the contacts besides the modes, (N_c, N_c)."""
        return np.asarray(self.contacts @ self.past_modes(self.contacts.conj().T.toarray()))


def _lowest(stiffness: Any, mass: Any, highest: float) -> tuple[Floats, Complexes]:
    """Return frequencies [rad/s] and mass-normalised modes up to a frequency, and one beyond."""
    size = stiffness.shape[0]
    if size <= _DENSE:
        square, shapes = scipy.linalg.eigh(stiffness.toarray(), mass.toarray())
    else:
        from scipy.sparse.linalg import eigsh  # takes long to import

        count = 16
        while True:
            # Below all frequencies, so that structures without supports have factors too.
            shift = -1e-6 * float(stiffness.diagonal().real.sum() / mass.diagonal().real.sum())
            square, shapes = eigsh(stiffness, count, mass, sigma=shift, v0=np.ones(size))
            if square.max() > highest**2 or count >= MOST_MODES:
                break
            count *= 2
        order = np.argsort(square, kind="stable")
        square, shapes = square[order], shapes[:, order]
    if square[0] <= 1e-10 * square[-1]:
        raise SlipmodeError(
            "stiffness: sectors with stuck contacts can move as a rigid body; hold the disk by "
            "springs to ground"
        )
    return np.sqrt(square), np.asarray(shapes, dtype=complex)
