"""Modes of a structure with stuck contacts as amplitudes of first order, in two groups.

The amplitudes of slow modes follow `tone_flow`. Fast modes, far from the carrier, respond to
forces at the carrier as in a steady state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import frozen

# Frequencies of slow modes, relative to the carrier. With stuck contacts modes may be far above
# the carrier, with slipping ones they come close to it. Modes below a third of the carrier follow
# no resonance, and their free vibration is no slow change of the motion at the carrier.
_LOWEST, _HIGHEST = 1.0 / 3.0, 2.0


@frozen
class DampedModes:
    """Modes a_m with a_m' = (s_m - i Omega) a_m + excitation F + projection y.

    Attributes
    ----------
    pole : (M,) complex ndarray
        s_m [1/s], with positive or negative frequencies.
    shapes : (R, M) complex ndarray
        In the modal coordinates.
    motion : (N_c, M) complex ndarray
        Displacements of the contacts per amplitude.
    projection : (M, N_c) complex ndarray
        Rates of the amplitudes per force deficit of the contacts.
    excitation, conjugate : (M,) complex ndarray
        Rates of the amplitudes per magnitude of the force, and of its complex conjugate.
    """

    pole: Complexes
    shapes: Complexes
    motion: Complexes
    projection: Complexes
    excitation: Complexes
    conjugate: Complexes

    def select(self, which: Any) -> Self:
        """Return some of the modes."""
        return type(self)(
            self.pole[which],
            self.shapes[:, which],
            self.motion[:, which],
            self.projection[which],
            self.excitation[which],
            self.conjugate[which],
        )

    def steady(self, frequency: float, rates: Complexes) -> Complexes:
        """Return steady amplitudes under rates (M, ...) at a frequency [rad/s]."""
        return np.asarray((rates.T / (1j * frequency - self.pole)).T)


@frozen
class ToneModes:
    """A structure with stuck contacts, under one force of varying magnitude F and frequency.

    The contacts move by x = slow.motion a + displacement F + flexibility y at the carrier.

    Attributes
    ----------
    slow, fast : DampedModes
        Near the carrier, and all others.
    static_flexibility : (N_c, N_c) complex ndarray
        Of the contacts besides all modes [m/N].
    static_displacement : (N_c,) complex ndarray
        Of the contacts besides all modes, per magnitude of the force [m].
    expand : callable
        Displacements of the structure by modal coordinates (R,), F and y (N_c,).
    """

    slow: DampedModes
    fast: DampedModes
    static_flexibility: Complexes
    static_displacement: Complexes
    expand: Callable[[Complexes, complex, Complexes], Complexes]

    @classmethod
    def of(
        cls,
        stiffness: Complexes | Floats,
        damping: Complexes | Floats,
        motion: Complexes | Floats,
        force: Complexes | Floats,
        conjugate: Complexes | Floats,
        frequency: float,
        **given: Any,
    ) -> Self:
        """Return the damped modes of q'' + damping q' + stiffness q = force F + motion^H y.

        Parameters
        ----------
        stiffness, damping : (R, R) ndarray
            Hermitian, with stuck contacts.
        motion : (N_c, R) ndarray
            Displacements of the contacts per modal coordinate.
        force, conjugate : (R,) ndarray
            Per magnitude of the force, and of its complex conjugate.
        frequency : float
            Carrier [rad/s].
        **given
            The other attributes.
        """
        square, U = np.linalg.eigh(stiffness)
        C = U.conj().T @ damping @ U
        # The poles of p'' + C p' + diag(square) p = 0.
        size = square.size
        state = np.block([[np.zeros((size, size)), np.eye(size)], [-np.diag(square), -C]])
        pole, right = np.linalg.eig(state)
        participation = np.linalg.inv(right)[:, size:] @ U.conj().T
        shapes = U @ right[:size]
        every = DampedModes(
            pole,
            shapes,
            motion @ shapes,
            participation @ motion.conj().T,
            participation @ force,
            participation @ conjugate,
        )
        near = (pole.imag >= _LOWEST * frequency) & (pole.imag <= _HIGHEST * frequency)
        return cls(every.select(near), every.select(~near), **given)

    def flexibility(self, frequency: float) -> Complexes:
        """Return the flexibility of the contacts without the slow modes, (N_c, N_c) [m/N]."""
        fast = self.fast
        by_modes = fast.motion @ fast.steady(frequency, fast.projection)
        return np.asarray(by_modes + self.static_flexibility)

    def displacement(self, frequency: float) -> Complexes:
        """Return displacements (N_c,) by the force without the slow modes [m]."""
        fast = self.fast
        by_modes = fast.motion @ fast.steady(frequency, fast.excitation)
        return np.asarray(by_modes + self.static_displacement)

    def modal(
        self, frequency: float, amplitude: Complexes, magnitude: complex, deficit: Complexes
    ) -> Complexes:
        """Return the modal coordinates (R,)."""
        fast = self.fast
        rates = fast.excitation * magnitude + fast.projection @ deficit
        return np.asarray(
            self.slow.shapes @ amplitude + fast.shapes @ fast.steady(frequency, rates)
        )
