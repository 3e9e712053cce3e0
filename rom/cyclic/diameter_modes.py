"""Modes of one nodal diameter with stuck contacts, and how its contacts respond to forces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Flags, Floats, frozen
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.reduction import (
    MOST_MODES,
    InternalResonance,
    Order,
    harmonic_decay,
    harmonic_gain,
)
from slipmode.rom.structure import NotPositiveDefiniteError, lowest_modes

# Square of the lowest frequency below which sectors move as a rigid body, relative to the largest
# stiffness per mass of a DOF: rounding errors of assembly are 1e-16 of it.
_SMALLEST = 1e-14


@frozen
class SlowMode:
    """A mode with a slow flow at the frequency of its carrier.

    Dampers and aerodynamic forces move the other modes with it, and the forces on these act on it
    through them:
    (stiffness + indirect) a = receiving^H (forces), u = shape a + response without the mode.

    Attributes
    ----------
    shape, receiving : (n_s,) complex ndarray
        [kg^-1/2]
    stiffness : complex
        D = omega^2 - Omega^2 + i gamma Omega [rad^2/s^2], with aerodynamics.
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
    structural_damping : (modes,) ndarray
        phi^H C phi without aerodynamic forces [1/s].
    stiffness, damping : (modes, modes) complex ndarray
        With aerodynamic forces, which are not Hermitian [rad^2/s^2], [1/s].
    contact_motion : (N_c, modes) complex ndarray
        Of sector 0 per modal amplitude [kg^-1/2].
    contacts : (N_c, n_s) CSC matrix
        `CyclicStructure.contact_motion`.
    static : callable
        Displacements (n_s, m) by static forces (n_s, m) [m/N].
    """

    frequency: Floats
    shapes: Complexes
    structural_damping: Floats
    stiffness: Complexes
    damping: Complexes
    contact_motion: Complexes
    contacts: Any
    static: Callable[[Complexes], Complexes]

    @classmethod
    def of(
        cls,
        structure: CyclicStructure,
        nodal_diameter: int,
        reference: Floats,
        at_least: int,
        highest: Callable[[Floats], float],
    ) -> Self:
        """Return the modes of a nodal diameter.

        Parameters
        ----------
        structure : CyclicStructure
        nodal_diameter : int
        reference : (N_c,) ndarray
            k_ref [N/m].
        at_least : int
            Number of modes, if there are so many.
        highest : callable
            Square of the frequency up to which modes respond with their inertia
            [rad^2/s^2], from the squares of all that are known.

        Raises
        ------
        SlipmodeError
            If the sectors can move as a rigid body.
        """
        T = structure.expansion(nodal_diameter)
        M = (T.conj().T @ (structure.mass @ T)).tocsc()
        W = structure.contact_motion(nodal_diameter)
        size = M.shape[0]
        diagonal = abs(T.T) @ structure.stiffness.diagonal() + abs(W.T).power(2) @ reference
        try:
            static = StaticResponse(structure, nodal_diameter, reference)
            square, found = lowest_modes(
                static, lambda x: M @ x, size, min(at_least, size), highest, MOST_MODES
            )
            rigid = bool(square[0] <= _SMALLEST * float((diagonal / M.diagonal().real).max()))
        except (NotPositiveDefiniteError, scipy.linalg.LinAlgError):
            rigid = True
        if rigid:
            raise SlipmodeError(
                "stiffness: the disk with stuck contacts has a rigid-body mode; connect it to "
                "ground by springs"
            )
        shapes = found.astype(complex)
        everywhere = T @ shapes
        stiffness = np.diag(square).astype(complex)
        damping = everywhere.conj().T @ (structure.damping @ everywhere)
        structural = np.diag(damping).real
        if structure.aerodynamics is not None:
            q = structure.aerodynamics.directions.T @ everywhere
            air = structure.aerodynamics.of_diameter(structure.angle(nodal_diameter))
            stiffness, damping = (
                alone + q.conj().T @ each @ q
                for alone, each in zip((stiffness, damping), air, strict=True)
            )
        omega = np.sqrt(square)
        return cls(omega, shapes, structural, stiffness, damping, W @ shapes, W, static)

    def mirrored(self) -> DiameterModes:
        """Return the modes of the opposite nodal diameter, -k."""
        names = [each.name for each in fields(self) if each.name != "static"]
        arrays = {name: getattr(self, name).conj() for name in names}
        return replace(self, **arrays, static=lambda force: self.static(force.conj()).conj())

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
        static = self.static(np.asarray(force, dtype=complex))
        on_modes = self.shapes.conj().T @ force
        return np.asarray(static - self.shapes @ (on_modes / self.frequency[:, np.newaxis] ** 2))

    def slow_mode(self, mode: int, frequency: float) -> SlowMode:
        """Return a mode and what the others do with it, by dampers, at a frequency [rad/s]."""
        kept, stiffness = self._others(frequency, mode)
        dynamic = self.dynamic_stiffness(frequency)
        moved = -np.linalg.solve(stiffness, dynamic[kept, mode])
        returned = -np.linalg.solve(stiffness.T, dynamic[mode, kept])
        others, own = self.shapes[:, kept], self.shapes[:, mode]
        return SlowMode(
            shape=own + others @ moved,
            receiving=own + others @ returned.conj(),
            stiffness=complex(dynamic[mode, mode]),
            indirect=complex(dynamic[mode, kept] @ moved),
        )

    def _others(self, frequency: float, without: int | None) -> tuple[Flags, Complexes]:
        """Return which modes respond, and their dynamic stiffness at a frequency."""
        kept = np.arange(self.frequency.size) != (-1 if without is None else without)
        return kept, self.dynamic_stiffness(frequency)[np.ix_(kept, kept)]

    def dynamic_stiffness(self, frequency: float) -> Complexes:
        """Return the dynamic stiffness of the modes at a frequency [rad/s], (modes, modes)."""
        inertia = frequency**2 * np.eye(self.frequency.size)
        return np.asarray(self.stiffness - inertia + 1j * frequency * self.damping)

    def growth(self) -> tuple[Floats, Floats]:
        """Return frequencies [rad/s] and growth rates [1/s] of free motion, (modes,)."""
        size = self.frequency.size
        unit, zero = np.eye(size), np.zeros((size, size))
        roots = np.linalg.eigvals(np.block([[zero, unit], [-self.stiffness, -self.damping]]))
        forward = roots[np.argsort(roots.imag)][size:]
        return forward.imag, forward.real

    def flexibility(self, frequency: float, without: int | None = None) -> Complexes:
        """Return contact displacements of sector 0 per force on its contacts, (N_c, N_c)."""
        kept, stiffness = self._others(frequency, without)
        psi = self.contact_motion[:, kept]
        return np.asarray(psi @ np.linalg.solve(stiffness, psi.conj().T) + self.past_flexibility)

    def internal_resonance(
        self, springs: Floats, frequency: ArrayLike, order: Order, name: str
    ) -> InternalResonance:
        """Return the mode with the largest gain at a harmonic.

        See `slipmode.rom.reduction.interaction.internal_resonance`.

        Parameters
        ----------
        springs : (N_c,) ndarray
            k_ref [N/m].
        frequency : float or (points,) array_like
            Frequencies nu of the harmonic [rad/s].
        order : (n, m)
            Harmonic.
        name : str
            Name of a mode with {} in place of its number.
        """
        nu = np.atleast_1d(frequency)[:, np.newaxis]
        dynamic = np.diag(self.stiffness) - nu**2 + 1j * nu * np.diag(self.damping)
        own = np.max(springs[:, np.newaxis] * np.abs(self.contact_motion) ** 2, axis=0)
        gain = harmonic_gain(own, dynamic, harmonic_decay(order))
        at, mode = (int(each) for each in np.unravel_index(gain.argmax(), gain.shape))
        found, omega = abs(float(nu[at, 0])), float(self.frequency[mode])
        largest = float(gain[at, mode])
        return InternalResonance(largest, order, found, omega, name.format(mode))

    @cached_property
    def past_flexibility(self) -> Complexes:
        """Static flexibility of the contacts besides the modes, (N_c, N_c)."""
        return np.asarray(self.contacts @ self.past_modes(self.contacts.conj().T.toarray()))


class StaticResponse:
    """Displacements by static forces in one nodal diameter, with springs at the contacts.

    Nodal diameters differ only in how the boundary moves: the sides where sectors meet, and the
    contacts. With interior i and boundary b, the boundary has the stiffness
    S = K_bb - K_bi K_ii^-1 K_ib. In nodal diameter k, whose boundary moves by T_k x with its free
    DOFs x, it is the small Hermitian T_k^H S T_k with the springs of the contacts.

    Parameters
    ----------
    structure : CyclicStructure
    nodal_diameter : int
        k.
    reference : (N_c,) ndarray
        Stiffness of the springs [N/m].

    Raises
    ------
    NotPositiveDefiniteError
        If the interior can move while the boundary is held.
    scipy.linalg.LinAlgError
        If the stiffness is not positive definite.
    """

    def __init__(self, structure: CyclicStructure, nodal_diameter: int, reference: Floats) -> None:
        self._sector, self._free_dofs = structure.condensed, structure.free_dofs
        self._size = structure.stiffness.shape[0]
        boundary = self._sector.boundary
        free = np.isin(self._free_dofs, boundary)
        self._motion = T = structure.expansion(nodal_diameter).tocsr()[boundary][:, free]
        springs = structure.contact_motion(nodal_diameter)[:, free].toarray()
        S = T.conj().T @ (T.T @ self._sector.schur.T).T
        S = S + springs.conj().T @ (reference[:, np.newaxis] * springs)
        self._factor = scipy.linalg.cho_factor(S, check_finite=False)

    def __call__(self, force: Complexes) -> Complexes:
        """Return displacements (n_s, m) by forces (n_s, m)."""
        sector, T, free = self._sector, self._motion, self._free_dofs
        # complex columns (n, m) as real ones (n, 2 m)
        on_sector = np.zeros((self._size, force.shape[1]), dtype=complex)
        on_sector[free] = force
        reduced = sector.forward(on_sector.view(float)).copy().view(complex)
        passed = T.conj().T @ reduced[sector.boundary]
        moved = scipy.linalg.cho_solve(self._factor, passed, check_finite=False)
        reduced[sector.boundary] = T @ moved
        return np.asarray(sector.backward(reduced.view(float)).copy().view(complex)[free])


@frozen
class AllDiameters:
    """Modes of every nodal diameter, computed at their first use.

    Attributes
    ----------
    structure : CyclicStructure
    reference : (N_c,) ndarray
        k_ref [N/m].
    highest : float
        Frequency up to which modes respond with their inertia [rad/s].
    known : dict
        By nodal diameter modulo N.
    """

    structure: CyclicStructure
    reference: Floats
    highest: float
    known: dict[int, DiameterModes]

    def __call__(self, nodal_diameter: int) -> DiameterModes:
        """Return the modes of a nodal diameter."""
        N = self.structure.sectors
        k = nodal_diameter % N
        if k not in self.known:
            opposite = (N - k) % N
            if opposite in self.known:
                self.known[k] = self.known[opposite].mirrored()
            else:
                square = self.highest**2
                self.known[k] = DiameterModes.of(
                    self.structure, k, self.reference, 1, lambda squares: square
                )
        return self.known[k]
