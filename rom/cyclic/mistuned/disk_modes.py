"""Modes of all nodal diameters together, of the tuned disk and of disks whose blades differ.

The modes of the tuned disk, Phi_k = phi_k exp(i k 2 pi j / N) / sqrt(N) on sector j, are the
coordinates. Blades that differ couple the nodal diameters k and l by the discrete Fourier
transform of their deviations at k - l.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.short_repr import frozen


@frozen
class Excited:
    """An engine-order excitation: half the modal forces (R,), and static effects on contacts."""

    modal: Complexes
    conjugate: Complexes  # of the complex conjugate of the force, which turns the other way
    past_modes: Complexes  # (N N_c,), static displacement of the contacts besides the modes [m]


@frozen
class TunedModes:
    """R modes of the tuned disk with open contacts, those of nodal diameter 0 first."""

    structure: CyclicStructure
    by_diameter: Sequence[DiameterModes]

    @cached_property
    def diameter(self) -> np.ndarray:
        """Nodal diameter of each mode, (R,)."""
        counts = [modes.frequency.size for modes in self.by_diameter]
        return np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def turn(self) -> Complexes:
        """exp(i k 2 pi j / N) / sqrt(N) of each mode on sector j, (N, R)."""
        N = self.structure.sectors
        angle = 2.0 * np.pi * (np.outer(np.arange(N), self.diameter) % N) / N
        return np.asarray(np.exp(1j * angle) / np.sqrt(N))

    @cached_property
    def shapes(self) -> Complexes:
        """Displacement of the free DOFs of sector 0, times sqrt(N), (n_s, R)."""
        return np.hstack([modes.shapes for modes in self.by_diameter])

    @cached_property
    def square(self) -> Floats:
        """omega^2, (R,)."""
        return np.concatenate([modes.frequency for modes in self.by_diameter]) ** 2

    @cached_property
    def damping(self) -> Complexes:
        """Phi^H C Phi, (R, R): modes of one nodal diameter may be coupled."""
        full = np.zeros((self.square.size, self.square.size), dtype=complex)
        for k, modes in enumerate(self.by_diameter):
            own = np.flatnonzero(self.diameter == k)
            full[np.ix_(own, own)] = modes.damping
        return full

    @cached_property
    def blade(self) -> Complexes:
        """Stiffness of the blade of sector 0 in the modes, times N, (R, R)."""
        expand = self.structure.expansion
        moved = np.hstack([expand(k) @ modes.shapes for k, modes in enumerate(self.by_diameter)])
        return np.asarray(moved.conj().T @ (self.structure.blade @ moved))

    def stiffness(self, deviation: Floats) -> Complexes:
        """Return the change of the stiffness by deviations (..., N), (..., R, R)."""
        N = self.structure.sectors
        transform = np.fft.fft(deviation, axis=-1) / N
        between = (self.diameter[:, np.newaxis] - self.diameter) % N
        return np.asarray(transform[..., between] * self.blade)

    @cached_property
    def contacts(self) -> Complexes:
        """Displacements of all contacts, (N N_c, R)."""
        own = np.hstack([modes.contact_motion for modes in self.by_diameter])
        return (self.turn[:, np.newaxis] * own).reshape(-1, self.diameter.size)

    @cached_property
    def past_modes(self) -> Complexes:
        """Static flexibility of all contacts besides the modes, (N N_c, N N_c)."""
        return past_flexibility(self.by_diameter)

    def excited(self, engine_order: int, force: Complexes) -> Excited:
        """Return the effects of Re(f exp(i (Omega t + E 2 pi j / N))), with f (n_s,)."""
        k = engine_order % self.structure.sectors
        modes = self.by_diameter[k]
        static = modes.past_modes(force[:, np.newaxis])[:, 0]
        past = self.structure.around(0.5 * (modes.contacts @ static), k)
        return Excited(self._modal(k, force), self._modal(-k, force.conj()), past)

    def _modal(self, nodal_diameter: int, force: Complexes) -> Complexes:
        """Return half the modal forces (R,) of a wave of forces f (n_s,) on sector 0."""
        N = self.structure.sectors
        k = nodal_diameter % N
        modal = np.zeros(self.diameter.size, dtype=complex)
        on_sector = self.by_diameter[k].shapes.conj().T @ force
        modal[self.diameter == k] = 0.5 * np.sqrt(N) * on_sector
        return modal

    def displacement(self, modal: Complexes) -> Complexes:
        """Return displacements of the free DOFs of all sectors (..., N, n_s) by modes (..., R)."""
        return np.asarray((modal[..., np.newaxis, :] * self.turn) @ self.shapes.T)


def past_flexibility(by_diameter: Sequence[DiameterModes]) -> Complexes:
    """Return the static flexibility (N N_c, N N_c) of all contacts besides the modes."""
    N = len(by_diameter)
    own = [modes.past_flexibility for modes in by_diameter]
    between = np.fft.ifft(own, axis=0)  # by j - i
    apart = (np.arange(N)[:, np.newaxis] - np.arange(N)) % N
    size = N * between.shape[-1]
    return np.asarray(between[apart].swapaxes(1, 2).reshape(size, size))


def real_modes(by_diameter: Sequence[DiameterModes]) -> tuple[Floats, Floats]:
    """Return modes of the tuned disk as standing waves.

    Frequencies (modes,) [rad/s] and displacements of all contacts (modes, N N_c) [kg^-1/2].
    """
    N = len(by_diameter)
    frequency, motion = [], []
    for k, modes in enumerate(by_diameter[: N // 2 + 1]):
        turn = np.exp(2j * np.pi * (k * np.arange(N) % N) / N) / np.sqrt(N)
        single = k in (0, N / 2)
        for omega, psi in zip(modes.frequency, modes.contact_motion.T, strict=True):
            wave = (turn[:, np.newaxis] * psi).ravel()
            if single:  # real but for a phase
                at = int(np.abs(wave).argmax())
                wave = wave * np.exp(-1j * np.angle(wave[at]))
            parts = [wave.real] if single else [np.sqrt(2.0) * wave.real, np.sqrt(2.0) * wave.imag]
            motion += parts
            frequency += len(parts) * [omega]
    contacts = N * len(by_diameter[0].contact_motion)
    return np.array(frequency), np.array(motion).reshape(len(frequency), contacts)


@frozen
class MistunedModes:
    """Modes of disks whose blades differ, by pattern.

    Attributes
    ----------
    tuned : TunedModes
    square, damping : (patterns, R) ndarray
        omega^2 [rad^2/s^2] and modal damping [1/s].
    shapes : (patterns, R, R) complex ndarray
        In the modes of the tuned disk.
    contacts : (patterns, N N_c, R) complex ndarray
        Displacements of all contacts [kg^-1/2].
    """

    tuned: TunedModes
    square: Floats
    damping: Floats
    shapes: Complexes
    contacts: Complexes

    @classmethod
    def of(cls, tuned: TunedModes, deviation: Floats) -> Self:
        """Return the modes for deviations (patterns, N)."""
        change = tuned.stiffness(deviation)
        square, V = np.linalg.eigh(np.diag(tuned.square) + change)
        C = tuned.damping + tuned.structure.beta * change
        damping = np.einsum("prs,prt,pts->ps", V.conj(), C, V, optimize=True).real
        return cls(tuned, square, damping, V, tuned.contacts @ V)

    def at(self, frequency: float, excited: Excited) -> AtFrequency:
        """Return how the contacts respond at a frequency [rad/s]."""
        dynamic = self._dynamic(frequency)
        by_forces = np.einsum("prs,r->ps", self.shapes.conj(), excited.modal) / dynamic
        moved = (self.contacts @ by_forces[..., np.newaxis])[..., 0] + excited.past_modes
        flexibility = self.flexibility(frequency)
        return AtFrequency(self, frequency, dynamic, by_forces, flexibility, moved)

    def flexibility(self, frequency: float) -> Complexes:
        """Return G of all contacts at a frequency [rad/s], (patterns, N N_c, N N_c) [m/N]."""
        psi = self.contacts
        by_modes = (psi / self._dynamic(frequency)[:, np.newaxis]) @ psi.conj().swapaxes(1, 2)
        return np.asarray(by_modes + self.tuned.past_modes)

    def _dynamic(self, frequency: float) -> Complexes:
        """Return the dynamic stiffness of the modes, (patterns, R)."""
        return np.asarray(self.square - frequency**2 + 1j * frequency * self.damping)


@frozen
class AtFrequency:
    """Disks at one frequency.

    Attributes
    ----------
    modes : MistunedModes
    frequency : float
        [rad/s]
    dynamic : (patterns, R) complex ndarray
        Dynamic stiffness of the modes.
    modal : (patterns, R) complex ndarray
        Their displacement by the forces alone.
    flexibility : (patterns, N N_c, N N_c) complex ndarray
        G of the contacts [m/N].
    moved : (patterns, N N_c) complex ndarray
        x_0, their displacement by the forces alone [m].
    """

    modes: MistunedModes
    frequency: float
    dynamic: Complexes
    modal: Complexes
    flexibility: Complexes
    moved: Complexes

    def displacement(self, on_contacts: Complexes) -> Complexes:
        """Return displacements (patterns, N, n_s) under forces on the contacts (patterns, N N_c).

        The static displacement besides the modes is left out.
        """
        psi = self.modes.contacts.conj().swapaxes(1, 2)
        q = self.modal + (psi @ on_contacts[..., np.newaxis])[..., 0] / self.dynamic
        return self.modes.tuned.displacement((self.modes.shapes @ q[..., np.newaxis])[..., 0])
