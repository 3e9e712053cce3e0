"""What errors of the friction terms S_j are relative to: the terms of the amplitude equation."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.nonresonant import frictionless_force
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen

#: Amplitudes below this share of the range are outside the range of a table's stated error.
SMALLEST_SHARE = 1e-3
# Of the largest |S_j|, times the distance from rest, by the number of modes. One mode: where a
# structure without damping begins to slip, S_j cannot be exact relative to itself. Two modes:
# where a strong mode begins to make a contact slip, S_j of a weak mode has a linear kink along a
# slanted line. Relative to S_j of the weak mode alone, cells would have to be 3e-4 of the range
# wide there at a tolerance of 1e-2, some 10 000 of them.
_FLOOR = {1: 1e-2, 2: 1.0}


@frozen
class ErrorNorm:
    """Scale of the error of S_j at an amplitude.

        scale_j = max(|S_j| + gamma_j Omega_j |a_j|, floor rho max |S_j|),
        rho = max_k |a_k| / range_k,

    so that an error of `tolerance` times it changes frequency and damping of mode j by that part
    of the part due to friction and structural damping.

    Attributes
    ----------
    loss : (modes,) ndarray
        gamma_j Omega_j, the structural damping [rad/s^2].
    least : (modes,) ndarray
        |S_j| per rho that is rounding [N kg^-1/2].
    amplitude_range : (modes,) ndarray
        [kg^1/2 m]
    largest : (modes,) ndarray
        max |S_j| over the range, as far as it is known [N kg^-1/2].
    """

    loss: Floats
    least: Floats
    amplitude_range: Floats
    largest: Floats

    @classmethod
    def of(cls, reduced: Reduced, amplitude_range: Floats) -> Self:
        """Return the norm before any S_j is known."""
        loss = np.abs(reduced.modal_damping - reduced.aerodynamic_damping) * reduced.carrier
        # At least a millionth of the frictionless S_j: contact motion is exact to rounding and
        # march tolerance relative to the frictionless motion; smaller terms cannot be exact
        # relative to themselves.
        least = 1e-6 * frictionless_force(reduced) * amplitude_range
        return cls(loss, least, amplitude_range, np.zeros(amplitude_range.size))

    def known(self, S: Complexes) -> Self:
        """Return the norm with the largest of values S (..., modes or more)."""
        values = S[..., : self.loss.size]
        return replace(self, largest=np.abs(values).max(axis=tuple(range(S.ndim - 1))))

    def share(self, amplitudes: Floats) -> Floats:
        """Return rho (...,) of amplitudes (..., modes)."""
        return np.asarray((amplitudes / self.amplitude_range).max(axis=-1))

    def scale(self, amplitudes: Floats, S: Complexes) -> Floats:
        """Return scale_j (..., modes) at amplitudes (..., modes) with values S (..., modes)."""
        floor = _FLOOR[self.loss.size] * self.largest + self.least
        share = self.share(amplitudes)[..., np.newaxis]
        scale = np.maximum(np.abs(S) + self.loss * amplitudes, floor * share)
        return np.asarray(np.where(scale > 0.0, scale, 1.0))


def smallest_scale(reduced: Reduced, amplitude_range: Floats) -> Floats:
    """Return the amplitudes (modes,) below which marches repeat relative to these.

    The smallest of the stated error, or those at which the rounding of rigid contacts is visible.
    """
    share = SMALLEST_SHARE
    if reduced.contacts is None:
        rounding = 10.0 * np.finfo(float).eps * np.linalg.cond(reduced.stiffness)
        # At most a hundredth of the range: stiffness of 1e15 N/m next to 40 N/m still has tables
        # (tests/runner/plan/test_extreme_values.py).
        share = float(np.clip(rounding, SMALLEST_SHARE, 1e-2))
    return share * amplitude_range
