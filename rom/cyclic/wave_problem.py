"""The contact problem of a travelling wave, which is that of one sector.

In a wave of nodal diameter k sector j does what sector 0 does, later by the phase k 2 pi j / N.
Harmonic h of the contact forces therefore acts on nodal diameter h k modulo N, and the contacts of
sector 0 respond to it with the flexibility of that nodal diameter. The dual problem of elastic
contacts has the force deficit
y = k_ref x_c - f, with the contact forces f, see `slipmode.rom.reduction.stuck`:

    x_c = psi a e^(i theta) + c.c. + sum_h G_h y_h e^(i h theta),
    psi = W_k phi,        G_h = flexibility of nodal diameter h k at h Omega, without the mode,

and the mode is driven by psi^H y_1. Coupling and projection are conjugates, not equal, as the
phases of the contacts differ. Dampers between the modes change both a little, see `SlowMode`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.cyclic.diameter_modes import DiameterModes, SlowMode
from slipmode.rom.cyclic.dual_contacts import DualContacts
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.nonresonant import HIGHEST_HARMONIC
from slipmode.rom.short_repr import frozen


@frozen
class WaveCarrier:
    """The contact problem of a wave at the frequency of its carrier.

    Attributes
    ----------
    frequency : float
        Omega [rad/s].
    mode : SlowMode
    problem : ContactProblem
        Its S is psi_r^H y_1, with psi_r = W_k receiving.
    force : (n_s,) complex ndarray
        That holds the wave, on sector 0, in the scale that was given.
    modal_force : complex
        Its force on the mode.
    """

    frequency: float
    mode: SlowMode
    problem: ContactProblem
    force: Complexes
    modal_force: complex


@frozen
class WaveProblem:
    """A mode of a nodal diameter, and the contacts of a sector.

    Attributes
    ----------
    modes_of : callable
        `DiameterModes` of harmonic h: those of nodal diameter h k.
    mode : int
        The mode of nodal diameter k that has a slow flow.
    law : Elastic
        Of the contacts of a sector.
    """

    modes_of: Callable[[int], DiameterModes]
    mode: int
    law: Elastic

    @cached_property
    def own(self) -> DiameterModes:
        """Modes of the wave's nodal diameter."""
        return self.modes_of(1)

    @cached_property
    def motion(self) -> Complexes:
        """Psi, contact displacements per amplitude of the mode, (N_c,) [kg^-1/2]."""
        return np.asarray(self.own.contact_motion[:, self.mode])

    @cached_property
    def natural_frequency(self) -> float:
        """Omega_k with stuck contacts [rad/s]."""
        return float(self.own.frequency[self.mode])

    @cached_property
    def modal_damping(self) -> float:
        """Gamma = phi^H C phi [1/s]."""
        return float(self.own.damping[self.mode, self.mode].real)

    def at(self, frequency: float, force: Complexes) -> WaveCarrier:
        """Return the contact problem of a wave that a force holds steady at a frequency [rad/s].

        `force` (n_s,) is its pattern on sector 0, in any scale. In a steady state F / 2 =
        D a - psi_r^H y_1. The quasi-static displacement g F / 2 of the contacts therefore adds
        g D a to psi a, and -g psi_r^H to G_1.
        """
        own, mode = self.own, self.own.slow_mode(self.mode, frequency)
        psi, receiving = own.contacts @ mode.shape, own.contacts @ mode.receiving
        even = not self.law.elements(psi.size).odd
        flexibility = {
            (h, m): self.modes_of(h).flexibility(h * frequency, self.mode if h == 1 else None)
            for h, m in harmonic_orders(HIGHEST_HARMONIC[1], 1, even)
        }
        modal_force = complex(mode.receiving.conj() @ force)
        moved = own.response(force[:, np.newaxis], frequency, self.mode)[:, 0]
        g = own.contacts @ moved / modal_force
        flexibility[1, 0] = flexibility[1, 0] - np.outer(g, receiving.conj())
        psi = psi + (mode.stiffness + mode.indirect) * g
        problem = self.contacts.problem(frequency, psi, flexibility, receiving)
        return WaveCarrier(frequency, mode, problem, force, modal_force)

    @cached_property
    def contacts(self) -> DualContacts:
        """The contacts, marched with the static flexibility of the wave's nodal diameter."""
        own, psi = self.own, self.motion
        static = own.flexibility(0.0) - np.outer(psi, psi.conj()) / self.natural_frequency**2
        symmetric = 0.5 * (static.real + static.real.T)
        omega, damping = self.natural_frequency, self.modal_damping
        return DualContacts(self.law, symmetric, omega, damping, np.abs(psi))
