"""Damped modes of one disk with stuck contacts, in two groups: slow ones and fast ones.

The amplitudes of slow modes follow `disk_flow`. Fast modes, far above the carrier, respond to
forces at the carrier as in steady states.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.cyclic.mistuned.disk_modes import Excited, MistunedModes
from slipmode.rom.short_repr import frozen

# Highest frequency of a slow mode, relative to the carrier. With stuck contacts a family may reach
# far above the carrier, with slipping ones it comes close to it.
_HIGHEST = 2.0


@frozen
class DampedModes:
    """Modes a_m with a_m' = (s_m - i Omega) a_m + excitation F + projection y.

    Attributes
    ----------
    pole : (M,) complex ndarray
        s_m [1/s], with positive or negative frequencies.
    shapes : (R, M) complex ndarray
        In the modes of the tuned disk.
    motion : (N N_c, M) complex ndarray
        Displacements of the contacts per amplitude.
    projection : (M, N N_c) complex ndarray
        Rates of the amplitudes per force deficit of the contacts.
    excitation : (M,) complex ndarray
        Rates of the amplitudes per magnitude of the force.
    """

    pole: Complexes
    shapes: Complexes
    motion: Complexes
    projection: Complexes
    excitation: Complexes

    def select(self, which: Any) -> Self:
        """Return some of the modes."""
        return type(self)(
            self.pole[which],
            self.shapes[:, which],
            self.motion[:, which],
            self.projection[which],
            self.excitation[which],
        )

    def steady(self, frequency: float, rates: Complexes) -> Complexes:
        """Return steady amplitudes under rates (M, ...) at a frequency [rad/s]."""
        return np.asarray((rates.T / (1j * frequency - self.pole)).T)


@frozen
class StuckModes:
    """A disk with stuck contacts, for one pattern and one excitation.

    The contacts move by x = slow.motion a + displacement F + flexibility y at a carrier.

    Attributes
    ----------
    modes : MistunedModes
    slow, fast : DampedModes
        Up to twice the carrier, and all others.
    static_flexibility : (N N_c, N N_c) complex ndarray
        Of the contacts besides all modes [m/N].
    static_displacement : (N N_c,) complex ndarray
        Of the contacts besides all modes, per magnitude of the force [m].
    """

    modes: MistunedModes
    slow: DampedModes
    fast: DampedModes
    static_flexibility: Complexes
    static_displacement: Complexes

    @classmethod
    def of(
        cls,
        modes: MistunedModes,
        pattern: int,
        springs: Floats,
        excited: Excited,
        frequency: float,
    ) -> Self:
        """Return the modes of a pattern with the contact springs (N N_c,), near a frequency."""
        psi, P = modes.contacts[pattern], modes.tuned.past_modes
        # x = hold (psi q + P y + x_p), with the contact forces y - k_ref x.
        hold = np.linalg.inv(np.eye(springs.size) + P * springs)
        psi_stuck = hold @ psi
        K = np.diag(modes.square[pattern]) + psi.conj().T @ (springs[:, np.newaxis] * psi_stuck)
        square, U = np.linalg.eigh(0.5 * (K + K.conj().T))
        C = (U.conj().T * modes.damping[pattern]) @ U
        # The poles of q'' + C q' + diag(square) q = p.
        size = square.size
        state = np.block([[np.zeros((size, size)), np.eye(size)], [-np.diag(square), -C]])
        pole, right = np.linalg.eig(state)
        participation = np.linalg.inv(right)[:, size:] @ U.conj().T
        shapes = U @ right[:size]
        on_modes = modes.shapes[pattern].conj().T @ excited.modal
        on_modes = on_modes - psi_stuck.conj().T @ (springs * excited.past_modes)
        every = DampedModes(
            pole,
            modes.shapes[pattern] @ shapes,
            psi_stuck @ shapes,
            participation @ psi_stuck.conj().T,
            participation @ on_modes,
        )
        near = (pole.imag > 0.0) & (pole.imag <= _HIGHEST * frequency)
        return cls(
            modes,
            every.select(near),
            every.select(~near),
            hold @ P,
            hold @ excited.past_modes,
        )

    def flexibility(self, frequency: float) -> Complexes:
        """Return the flexibility of the contacts without the slow modes, (N N_c, N N_c) [m/N]."""
        fast = self.fast
        by_modes = fast.motion @ fast.steady(frequency, fast.projection)
        return np.asarray(by_modes + self.static_flexibility)

    def displacement(self, frequency: float) -> Complexes:
        """Return displacements (N N_c,) by the force without the slow modes [m]."""
        fast = self.fast
        by_modes = fast.motion @ fast.steady(frequency, fast.excitation)
        return np.asarray(by_modes + self.static_displacement)

    def blades(
        self, frequency: float, amplitude: Complexes, magnitude: float, deficit: Complexes
    ) -> Complexes:
        """Return displacements (N, n_s) of the free DOFs.

        The static displacement besides the modes is left out.
        """
        fast = self.fast
        rates = fast.excitation * magnitude + fast.projection @ deficit
        modal = self.slow.shapes @ amplitude + fast.shapes @ fast.steady(frequency, rates)
        return self.modes.tuned.displacement(modal)
