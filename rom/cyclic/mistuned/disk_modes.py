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
import scipy

from slipmode.rom.common import Complexes, Floats, frozen
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.slow import FastModes, ToneModes


@frozen
class Excited:
    """An engine-order excitation: half the modal forces (R,), and static effects on contacts."""

    modal: Complexes
    conjugate: Complexes  # of the complex conjugate of the force, which turns the other way
    past_modes: Complexes  # (N N_c,), static displacement of the contacts besides the modes [m]


@frozen
class TunedModes:
    """R modes of the tuned disk with open or stuck contacts, of nodal diameter 0 first."""

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
        return np.asarray(scipy.linalg.block_diag(*(modes.damping for modes in self.by_diameter)))

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
        N = self.structure.sectors
        between = np.fft.ifft([modes.past_flexibility for modes in self.by_diameter], axis=0)
        apart = (np.arange(N)[:, np.newaxis] - np.arange(N)) % N  # j - i
        size = N * self.structure.n_contacts
        return np.asarray(between[apart].swapaxes(1, 2).reshape(size, size))

    def fast_modes(self, frequency: float) -> FastModes:
        """Return the modes that are fast against a frequency [rad/s], as standing waves."""
        N, k = self.structure.sectors, self.diameter
        # The real and imaginary parts of a wave stand for the opposite nodal diameter, too. Of
        # nodal diameters 0 and N / 2 they are one mode in two parts.
        half = 2 * k <= N
        wave = self.contacts.T[half] * np.where(2 * k % N, np.sqrt(2.0), 1.0)[half, np.newaxis]
        motion = np.vstack((wave.real, wave.imag))
        omega = np.tile(np.sqrt(self.square[half]), 2)
        return FastModes.of(self.past_modes.real, omega, motion, frequency)

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
        on_modes = 0.5 * np.sqrt(N) * (self.shapes.conj().T @ force)
        return np.where(self.diameter == nodal_diameter % N, on_modes, 0.0)

    def displacement(self, modal: Complexes) -> Complexes:
        """Return displacements of the free DOFs of all sectors (..., N, n_s) by modes (..., R)."""
        return np.asarray((modal[..., np.newaxis, :] * self.turn) @ self.shapes.T)


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

    def flexibility(self, frequency: float) -> Complexes:
        """Return G of all contacts at a frequency [rad/s], (patterns, N N_c, N N_c) [m/N]."""
        psi = self.contacts
        by_modes = (psi / self._dynamic(frequency)[:, np.newaxis]) @ psi.conj().swapaxes(1, 2)
        return np.asarray(by_modes + self.tuned.past_modes)

    def moved(self, frequency: float, excited: Excited) -> Complexes:
        """Return the displacements of the contacts by the forces alone, (patterns, N N_c) [m]."""
        q = self._on_modes(excited) / self._dynamic(frequency)
        return np.asarray((self.contacts @ q[..., np.newaxis])[..., 0] + excited.past_modes)

    def displacement(
        self, frequency: float, excited: Excited, on_contacts: Complexes
    ) -> Complexes:
        """Return displacements (patterns, N, n_s) with forces (patterns, N N_c) on the contacts.

        The static displacement besides the modes is left out.
        """
        psi = self.contacts.conj().swapaxes(1, 2)
        forces = self._on_modes(excited) + (psi @ on_contacts[..., np.newaxis])[..., 0]
        q = forces / self._dynamic(frequency)
        return self.tuned.displacement((self.shapes @ q[..., np.newaxis])[..., 0])

    def tone_modes(
        self, pattern: int, springs: Floats, excited: Excited, frequency: float
    ) -> ToneModes:
        """Return the modes of a pattern with contact springs (N N_c,), near a frequency [rad/s].

        They expand to displacements (N, n_s), without the static displacement besides the modes.
        """
        psi, P = self.contacts[pattern], self.tuned.past_modes
        # x = hold (psi q + P y + x_p), with the contact forces y - k_ref x.
        hold = np.linalg.inv(np.eye(springs.size) + P * springs)
        psi_stuck = hold @ psi
        K = np.diag(self.square[pattern]) + psi.conj().T @ (springs[:, np.newaxis] * psi_stuck)
        shapes = self.shapes[pattern]

        def on_modes(modal: Complexes, past_modes: Complexes) -> Complexes:
            on_springs = psi_stuck.conj().T @ (springs * past_modes)
            return np.asarray(shapes.conj().T @ modal - on_springs)

        def blades(modal: Complexes, magnitude: complex, deficit: Complexes) -> Complexes:
            return self.tuned.displacement(shapes @ modal)

        return ToneModes.of(
            0.5 * (K + K.conj().T),
            np.diag(self.damping[pattern]),
            psi_stuck,
            on_modes(excited.modal, excited.past_modes),
            on_modes(excited.conjugate, excited.past_modes.conj()),
            frequency,
            static_flexibility=hold @ P,
            static_displacement=hold @ excited.past_modes,
            expand=blades,
        )

    def _on_modes(self, excited: Excited) -> Complexes:
        """Return half the modal forces, (patterns, R)."""
        return np.asarray((excited.modal.conj() @ self.shapes).conj())

    def _dynamic(self, frequency: float) -> Complexes:
        """Return the dynamic stiffness of the modes, (patterns, R)."""
        return np.asarray(self.square - frequency**2 + 1j * frequency * self.damping)
