"""What each contact does at one frequency, with an amplitude of its own.

At the higher harmonics a contact responds to its own force by its own flexibility g_h; what it
does to other contacts there is of second order. Its force deficit at the carrier is then
y(|x|) x / |x| of its own displacement 2 Re(x exp(i Omega t)): one function for each kind of
contact, whatever the modes. On a disk the contacts of all sectors are of the same kinds, and g_h
is the mean over all nodal diameters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts

STEPS = 512  # per period
_MARCH = 1e-8  # distance from periodicity
# Displacements past the onset, relative to it: close to one another where slip begins.
_NODES, _NEAREST, _FARTHEST = 500, 1e-6, 1e5
HIGHEST = 15  # harmonic to which the contacts respond


@frozen
class LocalContacts:
    """The force deficit of each kind of contact against its displacement.

    Attributes
    ----------
    onset : float
        |x| at which the first contact begins to slip [m].
    secant : CubicHermiteSpline
        y / |x| of the kinds, real and imaginary parts (2 kinds,) [N/m], against
        log(|x| / onset - 1). It ends where the contacts hardly hold.
    """

    onset: float
    secant: Any

    @property
    def kinds(self) -> int:
        """Number of kinds of contacts."""
        return int(self.secant.c.shape[-1]) // 2

    @classmethod
    def of(
        cls,
        law: Elastic,
        at_carrier: Complexes,
        flexibility: Callable[[float], Complexes],
        frequency: float,
    ) -> Self:
        """Return the contacts of a law.

        Parameters
        ----------
        law : Elastic
        at_carrier : (kinds,) complex ndarray
            g_1 of each contact, with which the displacement below is the drive, x - g_1 y; 0: the
            displacement itself.
        flexibility : callable
            Flexibility (kinds,) of each contact to its own force at a frequency [rad/s]: g_h of
            the odd harmonics h = 3, 5, ...
        frequency : float
            Omega [rad/s].
        """
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator  # take long to import

        odd = range(3, HIGHEST + 1, 2)
        every = [at_carrier, *(flexibility(h * frequency) for h in odd)]
        # each contact on its own
        own = {(h, 0): np.diag(g) for h, g in zip((1, *odd), every, strict=True)}
        dual = DualContacts(law, np.diag(np.maximum(every[-1].real, 0.0)), np.array([frequency]))
        problem = dual.problem(np.ones((1, at_carrier.size), dtype=complex), own)
        limit, stiffness = law.elements(at_carrier.size).slider.T
        onset = 0.5 * float((limit / stiffness).min())
        past = np.geomspace(_NEAREST, _FARTHEST, _NODES)
        sizes = onset * (1.0 + past)
        terms = problem.on(Discretisation(STEPS, 1), _MARCH).solve(sizes[:, np.newaxis])
        terms.check_periodic()
        ratio = terms.P[:, 0] / sizes[:, np.newaxis]
        parts, log = np.hstack((ratio.real, ratio.imag)), np.log(past)
        slopes = PchipInterpolator(log, parts)(log, 1)
        return cls(onset, CubicHermiteSpline(log, parts, slopes))

    def __call__(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y and its derivatives by x and by conj(x), at displacements x (..., 1, N_c).

        Derivatives are (..., 1, 1, N_c). Contact j is of the kind j modulo the number of kinds.
        """
        given, x = x, x.reshape(*x.shape[:-1], -1, self.kinds)
        size = np.maximum(np.abs(x), np.finfo(float).tiny)
        past = size / self.onset - 1.0
        slips = past > _NEAREST
        log = np.log(np.clip(past, _NEAREST, _FARTHEST))
        columns = np.arange(self.kinds)
        k, by_log = (
            each[..., columns, columns] + 1j * each[..., columns, columns + self.kinds]
            for each in (self.secant(log), self.secant(log, 1))
        )
        k = np.where(slips, k, 0.0)
        # |x| dk/d|x|
        bends = np.where(slips & (past < _FARTHEST), by_log * size / (size - self.onset), 0.0)
        turn = (x / size) ** 2
        y, by_x, by_conjugate = (
            np.asarray(each, dtype=complex).reshape(given.shape)
            for each in (k * x, k + 0.5 * bends, 0.5 * bends * turn)
        )
        return y, by_x[..., np.newaxis, :], by_conjugate[..., np.newaxis, :]
