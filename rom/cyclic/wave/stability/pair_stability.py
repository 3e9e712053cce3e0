"""Stability of a wave of nodal diameter k against pairs of waves n and 2 k - n of its family.

Small waves a_n and a_m, m = 2 k - n, move the contacts of sector 0, in the phase of the wave, by

    Z e^(i q 2 pi j / N) + c.c.,    q = n - k,    Z(theta) with harmonics Z_h of both signs.

Harmonic h has the nodal diameter h k + q and the frequency h Omega. The contacts respond to small
displacements by R, the derivative of their periodic motion in the wave, in which the flexibility
of harmonic h is G_hk. In the pair it differs by D_h = G_(hk+q) - G_hk:

    y = R (psi_n a_n e_1 + conj(psi_m a_m) e_-1 + D y).

The pair obeys a_n'' + (2 i Omega + gamma_n) a_n' + D_n a_n = psi_n^H y_1, and likewise with
conj(a_m) and y_-1. Rates of the contacts are left out, as in a slow flow of first order.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.common import Complexes, frozen
from slipmode.rom.cyclic.structure import excited_diameter

if TYPE_CHECKING:
    from slipmode.rom.cyclic.wave.wave_state import Balance

_HIGHEST = 9  # harmonic that differs in the pair; others have the flexibility of the wave
_CHANGE = 1e-4  # of the contact displacement, of finite differences


@frozen
class CriticalPair:
    """Hold the pair of waves with the largest growth rate in the presence of a wave.

    Attributes
    ----------
    nodal_diameters : (int, int)
        Nodal diameters n and 2 k - n, -((N - 1) // 2) to N // 2. Both are k for the wave itself.
    growth : float
        Growth rate [1/s]; negative if all pairs decay.
    """

    nodal_diameters: tuple[int, int]
    growth: float


def critical_pair(balance: Balance, size: float) -> CriticalPair:
    """Return the most critical pair of all nodal diameters for a wave of the size |a|."""
    wave = balance.carrier.wave
    k, sectors = wave.nodal_diameter, wave.structure.sectors
    contacts = _PairContacts.of(balance, size)
    found = []
    for q in range(wave.structure.highest_diameter + 1):
        roots = _roots(balance, contacts, q)
        if q == 0 and not balance.carrier.force.any():
            # The phase of a limit cycle is arbitrary.
            roots = np.delete(roots, np.abs(roots).argmin())
        pair = excited_diameter(k + q, sectors), excited_diameter(k - q, sectors)
        found.append(CriticalPair(pair, float(roots.real.max())))
    return max(found, key=lambda pair: pair.growth)


@frozen
class _PairContacts:
    """How the contacts respond in a wave.

    Attributes
    ----------
    harmonics : (H,) ndarray of int
        h of both signs.
    flexibility : (H, N_c, N_c) complex ndarray
        G_hk of the wave [m/N].
    response : (H, N_c, H, N_c) complex ndarray
        R, derivative of the force deficits by displacements [N/m].
    """

    harmonics: NDArray[np.intp]
    flexibility: Complexes
    response: Complexes

    @classmethod
    def of(cls, balance: Balance, size: float) -> Self:
        """Return the contacts in a wave of the size |a|, by finite differences."""
        problem = balance.problem
        kept = [at for at, order in enumerate(problem.orders) if order[0] <= _HIGHEST]
        positive = np.array([problem.orders[at][0] for at in kept])
        moving = positive > 0
        G = (problem.forces.reaction - problem.reduced.stiffness)[kept]
        rest = np.zeros((len(problem.orders), G.shape[1]), dtype=complex)
        change = _CHANGE * size * float(np.abs(problem.forces.coupling).max())
        guess: Complexes | None = None

        def deficits(displacement: Complexes) -> Complexes:
            forces = replace(problem.forces, constant=displacement)
            other = replace(balance, problem=replace(problem, given_forces=forces))
            return other.terms(np.array([size]), guess).P

        def derivative(at: int, contact: int, part: complex) -> Complexes:
            small = rest.copy()
            small[at, contact] = part * change
            return np.asarray((deficits(small) - deficits(-small))[0, kept] / (2.0 * change))

        guess = deficits(rest)
        harmonics = np.concatenate((positive, -positive[moving]))
        R = np.zeros((harmonics.size, G.shape[1]) * 2, dtype=complex)
        for column, at in enumerate(kept):
            mirror = harmonics.tolist().index(-harmonics[column])
            for contact in range(G.shape[1]):
                # y = direct x + mirrored conj(x) of complex x; the mean displacement is real
                direct = mirrored = derivative(at, contact, 1.0)
                if moving[column]:
                    imaginary = 1j * derivative(at, contact, 1j)
                    direct, mirrored = 0.5 * (direct - imaginary), 0.5 * (direct + imaginary)
                R[:, :, column, contact] = np.vstack((direct, mirrored[moving].conj()))
                R[:, :, mirror, contact] = np.vstack((mirrored, direct[moving].conj()))
        return cls(harmonics, np.concatenate((G, G[moving].conj())), R)


def _roots(balance: Balance, contacts: _PairContacts, q: int) -> Complexes:
    """Return the two eigenvalues [1/s] of the waves k + q and k - q."""
    wave, Omega = balance.carrier.wave, balance.carrier.frequency
    k, sides = wave.nodal_diameter, (1, -1)
    families = [wave.modes_of(k + side * q) for side in sides]
    slow = [modes.slow_mode(wave.mode, Omega) for modes in families]

    def flexibility(h: int) -> Complexes:
        if h in sides:  # without the mode; that of h = -1 is the conjugate of k - q at Omega
            G = families[sides.index(h)].flexibility(Omega, wave.mode)
            return G if h == 1 else G.conj()
        return wave.modes_of(h * k + q).flexibility(h * Omega)

    def pair(values: Iterable[Complexes | complex]) -> Complexes:
        """Return what belongs to a_n and to conj(a_m)."""
        first, second = values
        return np.array([first, np.conj(second)])

    others = np.array([flexibility(h) for h in contacts.harmonics.tolist()])
    D = scipy.linalg.block_diag(*(others - contacts.flexibility))
    R = contacts.response.reshape(D.shape)
    moved = pair(m.contacts @ s.shape for m, s in zip(families, slow, strict=True))
    driven = pair(m.contacts @ s.receiving for m, s in zip(families, slow, strict=True))
    y = np.linalg.solve(np.eye(len(D)) - R @ D, R).reshape(contacts.response.shape)
    at = [contacts.harmonics.tolist().index(side) for side in sides]
    stiffness = np.diag(pair(each.stiffness + each.indirect for each in slow))
    rate = np.diag(pair(2j * Omega + each.damping[wave.mode, wave.mode] for each in families))
    force = np.einsum("ic,icjd,jd->ij", driven.conj(), y[at][:, :, at], moved) - stiffness
    roots = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [force, -rate]]))
    # The others are near -2 i Omega and 2 i Omega.
    return np.asarray(roots[np.argsort(np.abs(roots.imag))[:2]])
