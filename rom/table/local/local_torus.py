"""What each contact does under two tones, with amplitudes of its own.

The contacts respond to their harmonics by their own static flexibility, and do not act on each
other. Their force deficits at the carriers are then y_t(|x_A|, |x_B|) x_t / |x_t|. They are
computed where they are needed: a table over both amplitudes would cost more than a steady state.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts

_GRID = Discretisation(64, 16)  # an initial guess and derivatives need no more
_MARCH = 1e-6  # distance from periodicity
_CHANGE = 1e-3  # of a displacement, for derivatives, relative to the larger one of the contact


@frozen
class LocalTorus:
    """The force deficit of each contact at two carriers against its displacements.

    Attributes
    ----------
    dual : DualContacts
    carrier : (2,) ndarray
        [rad/s]
    """

    dual: DualContacts
    carrier: Floats

    @classmethod
    def of(cls, law: Elastic, flexibility: Floats, carrier: Floats) -> Self:
        """Return contacts with their own static flexibilities (N_c,) [m/N]."""
        static = np.diag(np.maximum(flexibility, 0.0))
        return cls(DualContacts(law, static, carrier, np.zeros(2)), carrier)

    def __call__(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y and its derivatives by x and by conj(x), at displacements x (..., 2, N_c).

        Derivatives (..., 2, 2, N_c) are of y at the first carrier by x at the second one.
        """
        rows = x.reshape(-1, *x.shape[-2:])
        found = [self._single(each) for each in rows]
        y, by_x, by_conjugate = (np.array(each) for each in zip(*found, strict=True))
        shape = (*x.shape[:-1], *x.shape[-2:])
        return y.reshape(x.shape), by_x.reshape(shape), by_conjugate.reshape(shape)

    def _single(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y (2, N_c) and derivatives (2, 2, N_c) at displacements (2, N_c)."""
        size = np.maximum(np.abs(x), np.finfo(float).tiny)
        turn = np.where(np.abs(x) > 0.0, x / size, 1.0)
        change = _CHANGE * size.max(axis=0)
        y = self._deficit(size)
        slope = np.empty((2, *x.shape), dtype=complex)
        for tone, one in enumerate(np.eye(2)):
            slope[:, tone] = (self._deficit(size + one[:, np.newaxis] * change) - y) / change
        secant = np.eye(2)[..., np.newaxis] * (y / size)
        by_x = 0.5 * (slope + secant) * turn[:, np.newaxis] * turn.conj()
        by_conjugate = 0.5 * (slope - secant) * turn[:, np.newaxis] * turn
        return y * turn, by_x, by_conjugate

    def _deficit(self, size: Floats) -> Complexes:
        """Return y at real displacements (2, N_c)."""
        given = dict.fromkeys(CARRIERS, np.zeros((size.shape[1],) * 2, dtype=complex))
        problem = self.dual.problem(self.carrier, size.astype(complex), given)
        terms = problem.on(_GRID, _MARCH).solve([[1.0, 1.0]])
        terms.check_periodic()
        return np.asarray(terms.P[0])
