"""Elastic contacts whose displacement is given at the carrier and by flexibilities beyond it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.modes_alone import modes_alone
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen


@frozen
class DualContacts:
    """Contacts with the force deficit y = k_ref x_c - f, see `slipmode.rom.reduction.stuck`.

        x_c = sum_j coupling_j a_j exp(i theta_j) + c.c. + sum_nm G_nm y_nm exp(i (n, m) theta)

    Attributes
    ----------
    law : Elastic
    static : (N_c, N_c) ndarray
        Real flexibility of the march [m/N], symmetric and positive semidefinite, to which every
        harmonic adds what its own differs by. Harmonics that are not given have it.
    carriers : (tones,) ndarray
        Frequencies Omega_j [rad/s].
    marched_frequency : (modes,) ndarray, optional
        Natural frequencies of modes that are marched beside the contacts [rad/s], where a harmonic
        comes close to them. They are not part of `static`. The march has them with a damping of
        its own: every harmonic adds what they differ by.
    marched_motion : (modes, N_c) ndarray, optional
        Displacements of the contacts per amplitude of these modes [kg^-1/2].
    """

    law: Elastic
    static: Floats
    carriers: Floats
    marched_frequency: Floats | None = None
    marched_motion: Floats | None = None

    def problem(
        self, coupling: Complexes, flexibility: Mapping[Order, Complexes]
    ) -> ContactProblem:
        """Return the contact problem with G by harmonic (n, m).

        `coupling` (tones, N_c) may go on with given displacements at the harmonics that follow the
        carriers in `flexibility`.
        """
        tones = self.carriers.size
        moved, constant = coupling[:tones], np.zeros((len(flexibility), len(self.static)), complex)
        constant[tones : len(coupling)] = coupling[tones:]
        reaction = np.array([G - self.static for G in flexibility.values()], dtype=complex)
        given = constant if len(coupling) > tones else None
        forces = ContactForces(-moved, reaction, constant=given, projection=-moved.conj())
        return ContactProblem(self.reduced, self.law, tuple(flexibility), given_forces=forces)

    @cached_property
    def reduced(self) -> Reduced:
        """The carriers as modes that move no contact, and the contacts as the core reads them."""
        given = {"stiffness": -self.static}
        if self.marched_frequency is not None and self.marched_motion is not None:
            given["nonresonant_frequency"] = self.marched_frequency
            given["nonresonant_spring"] = -self.marched_motion
        elements = self.law.elements(len(self.static))
        still = np.zeros(self.carriers.size)
        return modes_alone(self.carriers, still, still[np.newaxis], elements, **given)
