"""What the contacts of a disk do at one frequency, each with an amplitude of its own.

At the higher harmonics a contact responds to its own force by the mean flexibility g_h of all
nodal diameters; what it does to other contacts there is of second order. Its force deficit at the
carrier is then y(|x|) x / |x| of its own displacement 2 Re(x exp(i Omega t)): one function for
each contact of a sector, whatever the waves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.dual_contacts import DualContacts
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.short_repr import frozen

STEPS = 512  # per period
_MARCH = 1e-8  # distance from periodicity
# Displacements past the onset, relative to it: close to one another where slip begins.
_NODES, _NEAREST, _FARTHEST = 500, 1e-6, 1e5
HIGHEST = 15  # harmonic to which the contacts respond


@frozen
class LocalContacts:
    """The force deficit of each contact of a sector against its displacement.

    Attributes
    ----------
    onset : float
        |x| at which the first contact begins to slip [m].
    secant : CubicHermiteSpline
        y / |x| of the contacts, real and imaginary parts (2 N_c,) [N/m], against
        log(|x| / onset - 1). It ends where the contacts hardly hold.
    """

    onset: float
    secant: Any

    @property
    def contacts(self) -> int:
        """Number N_c of contacts of a sector."""
        return int(self.secant.c.shape[-1]) // 2

    @classmethod
    def of(cls, law: Elastic, flexibility: Sequence[Complexes], frequency: float) -> Self:
        """Return the contacts of a sector.

        Parameters
        ----------
        law : Elastic
        flexibility : sequence of (N_c,) complex ndarray
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
        """Return y and its derivatives by x and by conj(x), at displacements x (..., N_c)."""
        size = np.maximum(np.abs(x), np.finfo(float).tiny)
        past = size / self.onset - 1.0
        slips = past > _NEAREST
        log = np.log(np.clip(past, _NEAREST, _FARTHEST))
        contacts = x.shape[-1]
        columns = np.arange(contacts)
        found, slope = (self.secant(log, k)[..., columns, :] for k in (0, 1))
        k, by_log = (
            each[..., columns, columns] + 1j * each[..., columns, columns + contacts]
            for each in (found, slope)
        )
        k = np.where(slips, k, 0.0)
        # |x| dk/d|x|
        bends = np.where(slips & (past < _FARTHEST), by_log * size / (size - self.onset), 0.0)
        turn = (x / size) ** 2
        return np.asarray(k * x), np.asarray(k + 0.5 * bends), np.asarray(0.5 * bends * turn)


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
