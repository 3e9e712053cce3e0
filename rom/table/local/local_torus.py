"""What each contact does under two tones, with amplitudes of its own.

The contacts respond to their harmonics by their own static flexibility, and do not act on each
other. Their force deficits at the carriers, and at harmonics near a mode, are computed where they
are needed: a table over all these amplitudes would cost more than a steady state.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS, Order
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts

_GRID = Discretisation(64, 16)  # an initial guess and derivatives need no more
_MARCH = 1e-6  # distance from periodicity
_CHANGE = 1e-3  # of a displacement, for derivatives, relative to the largest one of the contact


@frozen
class LocalTorus:
    """The force deficit of each contact at harmonics of two tones against its displacements.

    Attributes
    ----------
    dual : DualContacts
    orders : sequence of (n, m)
        The carriers, and harmonics at which displacements are given as well.
    """

    dual: DualContacts
    orders: Sequence[Order] = CARRIERS

    @classmethod
    def of(cls, law: Elastic, flexibility: Floats, carrier: Floats) -> Self:
        """Return contacts with their own static flexibilities (N_c,) [m/N]."""
        static = np.diag(np.maximum(flexibility, 0.0))
        return cls(DualContacts(law, static, carrier))

    def __call__(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y and its derivatives by x and by conj(x), at displacements x (..., orders, N_c).

        Derivatives (..., orders, orders, N_c) are of y at the first order by x at the second one.
        """
        rows = x.reshape(-1, *x.shape[-2:])
        found = [self._single(each) for each in rows]
        y, by_x, by_conjugate = (np.array(each) for each in zip(*found, strict=True))
        shape = (*x.shape[:-1], *x.shape[-2:])
        return y.reshape(x.shape), by_x.reshape(shape), by_conjugate.reshape(shape)

    def _single(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y (orders, N_c) and derivatives (orders, orders, N_c) at x (orders, N_c)."""
        change = _CHANGE * np.maximum(np.abs(x).max(axis=0), np.finfo(float).tiny / _CHANGE)
        y = self._deficit(x)
        slopes = np.empty((2, len(x), *x.shape), dtype=complex)
        for part, unit in enumerate((1.0, 1j)):
            for order, one in enumerate(np.eye(len(x))):
                moved = x + unit * one[:, np.newaxis] * change
                slopes[part, :, order] = (self._deficit(moved) - y) / change
        real, imaginary = slopes
        return y, 0.5 * (real - 1j * imaginary), 0.5 * (real + 1j * imaginary)

    def _deficit(self, x: Complexes) -> Complexes:
        """Return y at displacements (orders, N_c)."""
        given = dict.fromkeys(self.orders, np.zeros((x.shape[1],) * 2, dtype=complex))
        problem = self.dual.problem(x, given)
        terms = problem.on(_GRID, _MARCH).solve([[1.0, 1.0]])
        terms.check_periodic()
        return np.asarray(terms.P[0])
