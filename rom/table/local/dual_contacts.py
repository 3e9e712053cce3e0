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
    frequency, damping : (modes,) ndarray
        Natural frequencies [rad/s] and damping [1/s] of the modes; without any the carrier, 0.
    moved : (modes, N_c) ndarray, optional
        Sizes of the displacement per amplitude of each mode, a scale. Default: there is no mode.
    marched_frequency : (modes,) ndarray, optional
        Natural frequencies of modes that are marched beside the contacts [rad/s], where a harmonic
        comes close to them. They are not part of `static`. The march has them with a damping of
        its own: every harmonic adds what they differ by.
    marched_motion : (modes, N_c) ndarray, optional
        Displacements of the contacts per amplitude of these modes [kg^-1/2].
    """

    law: Elastic
    static: Floats
    frequency: Floats
    damping: Floats
    moved: Floats | None = None
    marched_frequency: Floats | None = None
    marched_motion: Floats | None = None

    def problem(
        self, carrier: Floats, coupling: Complexes, flexibility: Mapping[Order, Complexes]
    ) -> ContactProblem:
        """Return the contact problem at carriers (modes,) [rad/s], with G by harmonic (n, m).

        `coupling` (modes, N_c) may go on with given displacements at the harmonics that follow the
        carriers in `flexibility`.
        """
        modes = carrier.size
        constant = np.zeros((len(flexibility), len(self.static)), dtype=complex)
        constant[modes : len(coupling)] = coupling[modes:]
        forces = ContactForces(
            coupling=-np.asarray(coupling[:modes], dtype=complex),
            reaction=np.array([G - self.static for G in flexibility.values()], dtype=complex),
            constant=constant if len(coupling) > modes else None,
            projection=-np.conj(coupling[:modes]),
        )
        reduced = self.reduced.at_carrier(carrier.tolist())
        return ContactProblem(reduced, self.law, tuple(flexibility), given_forces=forces)

    @cached_property
    def reduced(self) -> Reduced:
        """The mode and the contacts as the core reads them, coupled by size alone."""
        given = {"stiffness": -self.static}
        if self.moved is not None:
            given["spring"] = -self.moved
        if self.marched_frequency is not None and self.marched_motion is not None:
            given["nonresonant_frequency"] = self.marched_frequency
            given["nonresonant_spring"] = -self.marched_motion
        return modes_alone(
            self.frequency,
            self.damping,
            np.zeros((1, self.frequency.size)),
            self.law.elements(len(self.static)),
            **given,
        )
