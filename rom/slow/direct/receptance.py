"""What all modes do at the harmonics of a steady state: D(nu) q = f / 2 - B(nu) P."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr


@dataclass(frozen=True, eq=False)
class Receptance:
    """What all modes do at the harmonics, (orders, ...): D, B and the reaction on the contacts.

    Attributes
    ----------
    resonant : ((pairs,) ndarray, (pairs,) ndarray)
        Harmonics and modes that steps of implicit Euler lead: the retained modes at their
        carriers first, then what is so near resonance that contacts and mode move each other.
    kappa : (pairs,) ndarray
        Of the first step [rad^2/s^2].
    """

    frequency: Floats
    D: Complexes
    B: Complexes
    follows: Complexes
    reaction: Complexes
    loads: Complexes
    resonant: tuple[NDArray[np.intp], NDArray[np.intp]]
    kappa: Floats

    __repr__ = short_repr

    @classmethod
    def of(
        cls,
        reduced: Reduced,
        orders: Sequence[Order],
        half: Floats,
        led: float = 0.0,
        first_step: float = 0.0,
    ) -> Receptance:
        """Under forces 2 half cos(Omega_j t) at the carriers; for the rest see ForcedBalance."""
        modes = len(half)
        nu = np.array(orders, dtype=float)[:, :modes] @ reduced.carrier
        D, B = reduced.modal_stiffness(nu), reduced.modal_coupling(nu)
        follows = reduced.following(nu)
        loads = np.zeros(B.shape[:2], dtype=complex)
        loads[:modes] = half @ reduced.all_shapes
        own = np.abs(np.einsum("qkk->qk", D))
        kappa = np.maximum(first_step * _detuning(reduced, B), np.finfo(float).tiny)
        near = own < led * kappa
        near[np.arange(modes), np.arange(modes)] = False
        pairs = np.argwhere(near)
        pairs = np.vstack((np.tile(np.arange(modes)[:, np.newaxis], 2), pairs))
        resonant = pairs[:, 0], pairs[:, 1]
        reaction = np.swapaxes(B, 1, 2) @ np.linalg.solve(D, B) + follows
        return cls(nu, D, B, follows, reaction, loads, resonant, kappa[resonant])

    def modal(self, P: Complexes) -> Complexes:
        """Displacement of all modes (orders, modes + nonresonant) by forces and contacts P."""
        still = np.zeros_like(self.kappa)
        return self.stepped_modal(P, still, still)

    def stepped_modal(self, P: Complexes, kappa: Floats, target: Complexes | Floats) -> Complexes:
        """That in a step from a displacement `target` (pairs,)."""
        D, loads = self.D.copy(), self.loads - np.einsum("qkc,qc->qk", self.B, P)
        q, k = self.resonant
        D[q, k, k] += 1j * kappa
        loads[q, k] += 1j * kappa * target
        return np.asarray(np.linalg.solve(D, loads[..., np.newaxis])[..., 0])

    def stepped_reaction(self, kappa: Floats) -> Complexes:
        """Of all modes in a step, (orders, N_c, N_c)."""
        q, k = self.resonant
        D, reaction = self.D.copy(), self.reaction.copy()
        D[q, k, k] += 1j * kappa
        some = np.unique(q)
        B = self.B[some]
        reaction[some] = np.swapaxes(B, 1, 2) @ np.linalg.solve(D[some], B) + self.follows[some]
        return reaction


def _detuning(reduced: Reduced, B: Complexes) -> Floats:
    """How far slip can detune modes (..., modes), of coupling B (..., modes, N_c) [rad^2/s^2]."""
    if reduced.contacts is not None:
        return np.asarray(np.abs(B) ** 2 @ reduced.contacts.reference)
    moved = np.linalg.solve(reduced.stiffness, np.swapaxes(B, -1, -2).conj())
    return np.asarray(np.abs(np.einsum("...kc,...ck->...k", B, moved)))
