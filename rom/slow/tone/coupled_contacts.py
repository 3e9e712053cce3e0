"""All contacts of a structure together, at the forcing frequency of one tone, or of two.

At the higher harmonics contacts act on each other by the flexibility of all modes there. At the
carriers, and at harmonics near a mode, they have a drive c, and a part of the response of modes:

    x_k = c_k + far_k y_k,    x_nm = G_nm y_nm  at all other odd harmonics n Omega_A + m Omega_B
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS, Order, harmonic_orders
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts
from slipmode.rom.table.local.local_contacts import STEPS, LocalContacts

_MARCH = 1e-7  # distance from periodicity
# Under two tones there are fewer steps and harmonics, because there are phase lines as well.
_TORUS_STEPS, LINES, _TORUS_HIGHEST = 128, 16, 7
FAST = 2.0  # harmonics may come close to modes beyond so many times the carrier


@frozen
class FastModes:
    """What all structures have in common that differ in their modes near the carrier alone.

    Attributes
    ----------
    static : (N_c, N_c) ndarray
        Static flexibility of the contacts besides all modes, stuck contacts included [m/N].
    frequency : (modes,) ndarray
        Natural frequencies from `FAST` times the carrier on, with stuck contacts [rad/s].
    motion : (modes, N_c) ndarray
        Displacements of the contacts in these modes [kg^-1/2].
    """

    static: Floats
    frequency: Floats
    motion: Floats

    @classmethod
    def of(cls, static: Floats, frequency: Floats, motion: Floats, carrier: float) -> Self:
        """Return the fast modes among real modes (modes,), (modes, N_c)."""
        fast = frequency >= FAST * carrier
        # Differences of flexibilities may be negative by rounding.
        size, directions = np.linalg.eigh(0.5 * (static + static.T))
        positive = (directions * np.maximum(size, 0.0)) @ directions.T
        return cls(positive, frequency[fast], motion[fast])

    def at(self, carrier: Floats) -> Floats:
        """Return their flexibility at carriers (tones,) [rad/s], (tones, N_c, N_c) [m/N]."""
        compliance = 1.0 / (self.frequency**2 - carrier[:, np.newaxis] ** 2)
        by_modes = (self.motion.T * compliance[:, np.newaxis]) @ self.motion
        return np.asarray(self.static + by_modes)


@frozen
class CoupledContacts:
    """Force deficits of all contacts against their drives.

    Attributes
    ----------
    dual : DualContacts
    far : (drives, N_c, N_c) ndarray
        Flexibility of the fast modes at the carriers, then static flexibility [m/N].
    flexibility : {(n, m): (N_c, N_c) complex ndarray}
        The same at the orders of the drives, then G_nm with stuck contacts [m/N].
    grid : Discretisation
    """

    dual: DualContacts
    far: Floats
    flexibility: Mapping[Order, Complexes]
    grid: Discretisation

    @classmethod
    def of(
        cls,
        law: Elastic,
        fast: FastModes,
        flexibility: Callable[[float], Complexes],
        frequency: Floats,
        finer: int = 1,
        driven: Sequence[Order] = CARRIERS[:1],
    ) -> Self:
        """Return the contacts at frequencies (tones,) [rad/s].

        Parameters
        ----------
        law : Elastic
            Of all contacts.
        fast : FastModes
        flexibility : callable
            Flexibility (N_c, N_c) of all modes with stuck contacts at a frequency [rad/s].
        frequency : (tones,) ndarray
            Carriers [rad/s].
        finer : int
            Factor of the number of steps, phase lines and harmonics.
        driven : sequence of (n, m)
            Harmonics that have a drive: the carriers, and others near a mode.
        """
        tones = frequency.size
        far = np.array([*fast.at(frequency), *(fast.static for _ in driven[tones:])])
        steps, lines, highest = STEPS, 1, LocalContacts.HIGHEST
        if tones == 2:
            quick = int(np.ceil(frequency.max() / frequency[0]))
            steps, lines, highest = quick * _TORUS_STEPS, finer * LINES, _TORUS_HIGHEST
        given = dict(zip(driven, far.astype(complex), strict=True))
        for order in harmonic_orders(finer * (highest + 1) - 1, tones):
            if order not in driven:
                given[order] = flexibility(float(np.dot(order[:tones], frequency)))
        modes = (fast.frequency, fast.motion) if fast.frequency.size else (None, None)
        dual = DualContacts(law, fast.static, frequency, *modes)
        return cls(dual, far, given, Discretisation(finer * steps, lines))

    def deficit(self, drive: Complexes, guess: Complexes | None = None) -> Complexes:
        """Return harmonics of y at drives c (drives, N_c), in the order of `flexibility`.

        `guess` are harmonics (orders, N_c) at a drive nearby, or the first of them.

        Raises
        ------
        UnsettledError
            If the contacts do not come to a periodic motion.
        """
        problem: ContactProblem = self.dual.problem(drive, self.flexibility)
        near = np.zeros((1, len(self.flexibility), drive.shape[1]), dtype=complex)
        if guess is not None:
            near[0, : len(guess)] = guess
        amplitude = np.ones((1, self.dual.carriers.size))
        terms = problem.on(self.grid, _MARCH).solve(amplitude, near)
        terms.check_periodic()
        return np.asarray(terms.P[0])
