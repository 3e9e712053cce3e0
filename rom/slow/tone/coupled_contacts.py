"""All contacts of a structure together, at one forcing frequency.

At the higher harmonics contacts act on each other by the flexibility of all modes there. At the
carrier they have a drive c, and the response of the modes that are fast against it:

    x_1 = c + far y_1,    x_h = G_h y_h  for h = 3, 5, ...
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts
from slipmode.rom.table.local.local_contacts import HIGHEST, STEPS

_MARCH = 1e-7  # distance from periodicity
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

    def at(self, carrier: float) -> Floats:
        """Return their flexibility at a carrier [rad/s], (N_c, N_c) [m/N]."""
        compliance = 1.0 / (self.frequency**2 - carrier**2)
        return np.asarray(self.static + (self.motion.T * compliance) @ self.motion)


@frozen
class CoupledContacts:
    """Force deficits of all contacts against their drives.

    Attributes
    ----------
    dual : DualContacts
    far : (N_c, N_c) ndarray
        Flexibility of the fast modes at the carrier [m/N].
    flexibility : (harmonics, N_c, N_c) complex ndarray
        G_h of the odd harmonics from h = 3 on, with stuck contacts [m/N].
    steps : int
        Per period.
    """

    dual: DualContacts
    far: Floats
    flexibility: Complexes
    steps: int

    @classmethod
    def of(
        cls,
        law: Elastic,
        fast: FastModes,
        flexibility: Callable[[float], Complexes],
        frequency: float,
        finer: int = 1,
    ) -> Self:
        """Return the contacts at a frequency [rad/s].

        Parameters
        ----------
        law : Elastic
            Of all contacts.
        fast : FastModes
        flexibility : callable
            Flexibility (N_c, N_c) of all modes with stuck contacts at a frequency [rad/s].
        frequency : float
            Carrier [rad/s].
        finer : int
            Factor of the number of steps and harmonics.
        """
        odd = range(3, finer * (HIGHEST + 1), 2)
        beyond = np.array([flexibility(h * frequency) for h in odd], dtype=complex)
        modes = (fast.frequency, fast.motion) if fast.frequency.size else (None, None)
        dual = DualContacts(law, fast.static, frequency, *modes)
        return cls(dual, fast.at(frequency), beyond, finer * STEPS)

    def deficit(self, drive: Complexes) -> Complexes:
        """Return y_1 at drives c (N_c,).

        Raises
        ------
        UnsettledError
            If the contacts do not come to a periodic motion.
        """
        every = [self.far.astype(complex), *self.flexibility]
        orders = [CARRIERS[0], *((2 * k + 3, 0) for k in range(len(self.flexibility)))]
        flexibility = dict(zip(orders, every, strict=True))
        problem: ContactProblem = self.dual.problem(drive, flexibility)
        terms = problem.on(Discretisation(self.steps, 1), _MARCH).solve([[1.0]])
        terms.check_periodic()
        return np.asarray(terms.P[0, 0])
