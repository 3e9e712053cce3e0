"""The structure that a reduced model stands for: its modes and what contacts do to it besides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.full.bases.orthonormal import orthonormal
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.structure import Structure


@dataclass(frozen=True, eq=False)
class ReducedStructure:
    """x = shapes c, the modes first in c.

    Attributes
    ----------
    structure : Structure
        M = I, K, C, W of the coordinates c, without the springs of elastic contacts.
    shapes : (n, coordinates) ndarray
        [kg^-1/2]
    """

    structure: Structure
    shapes: Floats

    __repr__ = short_repr

    @classmethod
    def of(cls, reduced: Reduced) -> Self:
        """Of a consistent reduced model.

        x = Phi q + X y is the model's own; M, K and C on (Phi, X) are in its coupling. Of elastic
        contacts K is K_s, with their springs, and X what it does statically under forces on them.
        """
        if reduced.contacts is None:
            return cls._bonded(reduced)
        omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
        inertia = np.vstack((np.zeros_like(reduced.spring), reduced.nonresonant_inertia))
        damper = np.vstack((reduced.damper, reduced.nonresonant_damper))
        springs = omega[:, np.newaxis] ** 2 * inertia
        drawn = springs - np.vstack((reduced.spring, reduced.nonresonant_spring))
        own = np.diag(np.append(reduced.modal_damping, reduced.nonresonant_damping))
        K = np.block([[np.diag(omega**2), springs], [springs.T, -reduced.stiffness]])
        C = np.block([[own + reduced.damping_coupling, damper], [damper.T, reduced.damping]])
        W = np.vstack((drawn, -reduced.stiffness))
        basis = orthonormal(inertia, reduced.carried_mass)
        W = basis.T @ W
        K, C = (basis.T @ matrix @ basis for matrix in (K, C))
        K -= (W * reduced.contacts.reference) @ W.T
        structure = Structure(np.eye(len(W)), 0.5 * (K + K.T), 0.5 * (C + C.T), contact=W)
        return cls(structure, np.hstack((reduced.all_shapes, reduced.contact_shapes)) @ basis)

    @classmethod
    def _bonded(cls, reduced: Reduced) -> Self:
        """About rigid contacts: y are their displacements."""
        omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
        inertia = np.vstack((np.zeros_like(reduced.spring), reduced.nonresonant_inertia))
        spring = np.vstack((reduced.spring, reduced.nonresonant_spring))
        damper = np.vstack((reduced.damper, reduced.nonresonant_damper))
        own = np.diag(np.append(reduced.modal_damping, reduced.nonresonant_damping))
        modal_damping = own + reduced.damping_coupling
        structure = Structure(
            np.block(
                [[np.eye(omega.size), inertia], [inertia.T, reduced.mass + reduced.carried_mass]]
            ),
            np.block([[np.diag(omega**2), spring], [spring.T, reduced.stiffness]]),
            np.block([[modal_damping, damper], [damper.T, reduced.damping]]),
            contact=list(range(omega.size, omega.size + reduced.n_contacts)),
        )
        return cls(structure, np.hstack((reduced.all_shapes, reduced.contact_shapes)))
