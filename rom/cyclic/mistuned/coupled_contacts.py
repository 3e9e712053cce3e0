"""All contacts of a disk together, at one forcing frequency.

At the higher harmonics contacts act on each other by the flexibility of all modes there. At the
carrier they have a drive c, and what the modes respond that are fast against it:

    x_1 = c + far y_1,    x_h = G_h y_h  for h = 3, 5, ...
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.cyclic.dual_contacts import DualContacts
from slipmode.rom.cyclic.mistuned.disk_modes import MistunedModes, past_flexibility, real_modes
from slipmode.rom.cyclic.mistuned.local_contacts import HIGHEST, STEPS
from slipmode.rom.laws.contacts import Contacts, Elastic
from slipmode.rom.reduction.combination import CARRIERS, Order
from slipmode.rom.short_repr import frozen

_MARCH = 1e-7  # distance from periodicity
_FAST = 2.0  # harmonics may come close to modes beyond so many times the carrier


@frozen
class CoupledContacts:
    """Force deficits of all contacts against their drives.

    Attributes
    ----------
    dual : DualContacts
    far : (N N_c, N N_c) ndarray
        Flexibility of the fast modes at the carrier [m/N].
    flexibility : mapping
        G_h (patterns, N N_c, N N_c) by harmonic (h, 0), from h = 3 on.
    """

    dual: DualContacts
    far: Floats
    flexibility: Mapping[Order, Complexes]

    @classmethod
    def of(
        cls, modes: MistunedModes, stuck: Sequence[DiameterModes], law: Elastic, frequency: float
    ) -> Self:
        """Return the contacts at a frequency [rad/s].

        Parameters
        ----------
        modes : MistunedModes
            With open contacts.
        stuck : sequence of DiameterModes
            Of the tuned disk with stuck contacts, by nodal diameter.
        law : Elastic
            Of the contacts of a sector.
        """
        N, size = len(stuck), modes.tuned.structure.n_contacts
        groups: Any = [(law, range(j * size, (j + 1) * size)) for j in range(N)]
        all_contacts = Contacts(groups)
        static = past_flexibility(stuck).real
        static = 0.5 * (static + static.T)
        omega, motion = real_modes(stuck, _FAST * frequency)
        far = static + (motion.T / (omega**2 - frequency**2)) @ motion
        springs = all_contacts.elements(N * size).reference
        flexibility: dict[Order, Complexes] = {}
        for h in range(3, HIGHEST + 1, 2):
            G = modes.flexibility(h * frequency)
            flexibility[h, 0] = np.asarray(np.linalg.solve(np.eye(N * size) + G * springs, G))
        carrier, undamped = np.array([frequency]), np.zeros(1)
        dual = DualContacts(all_contacts, static, carrier, undamped, None, omega, motion)
        return cls(dual, far, flexibility)

    def deficit(self, drive: Complexes) -> Complexes:
        """Return y_1 at drives c (patterns, N N_c).

        Raises
        ------
        UnsettledError
            If the contacts do not come to a periodic motion.
        """
        found = np.empty_like(drive)
        for pattern, c in enumerate(drive):
            flexibility: dict[Order, Complexes] = {CARRIERS[0]: self.far.astype(complex)}
            flexibility |= {order: G[pattern] for order, G in self.flexibility.items()}
            problem = self.dual.problem(self.dual.frequency, c[np.newaxis], flexibility)
            terms = problem.on(Discretisation(STEPS, 1), _MARCH).solve([[1.0]])
            terms.check_periodic()
            found[pattern] = terms.P[0, 0]
        return found
