"""What each contact does at one frequency, with an amplitude of its own.

At the higher harmonics a contact responds to its own force by its own flexibility g_h; what it
does to other contacts there is of second order. Its force deficit at the carrier is then
y(|x|) x / |x| of its own displacement 2 Re(x exp(i Omega t)): one function for each kind of
contact, whatever the modes. On a disk the contacts of all sectors are of the same kinds, and g_h
is the mean over all nodal diameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.contact.problem import ContactProblem
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
    def of(cls, law: Elastic, flexibility: Sequence[Complexes], frequency: float) -> Self:
        """Return the contacts of a law.

        Parameters
        ----------
        law : Elastic
        flexibility : sequence of (kinds,) complex ndarray
            g_h of the odd harmonics h = 1, 3, ... of each contact. With g_1 the displacement below
            is the drive, x - g_1 y; 0: the displacement itself.
        frequency : float
            Omega [rad/s].
        """
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator  # take long to import

        problem = local_problem(law, flexibility, frequency)
        limit, stiffness = law.elements(len(flexibility[0])).slider.T
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
        found, slope = (self.secant(log, k)[..., columns, :] for k in (0, 1))
        k, by_log = (
            each[..., columns, columns] + 1j * each[..., columns, columns + self.kinds]
            for each in (found, slope)
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


def local_problem(
    law: Elastic, flexibility: Sequence[Complexes], frequency: float
) -> ContactProblem:
    """Return contacts whose drive at the carrier is given, each on its own.

    `flexibility` as of `LocalContacts.of`.
    """
    contacts = len(flexibility[-1])
    static = np.diag(np.maximum(flexibility[-1].real, 0.0))
    own = {(2 * k + 1, 0): np.diag(g).astype(complex) for k, g in enumerate(flexibility)}
    carrier = np.array([frequency])
    dual = DualContacts(law, static, carrier, np.zeros(1))
    return dual.problem(carrier, np.ones((1, contacts), dtype=complex), own)
