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
        omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
        inertia = np.vstack((np.zeros_like(reduced.spring), reduced.nonresonant_inertia))
        spring = np.vstack((reduced.spring, reduced.nonresonant_spring))
        damper = np.vstack((reduced.damper, reduced.nonresonant_damper))
        own = np.diag(np.append(reduced.modal_damping, reduced.nonresonant_damping))
        C = np.block([[own + reduced.damping_coupling, damper], [damper.T, reduced.damping]])
        shapes = np.hstack((reduced.all_shapes, reduced.contact_shapes))
        if reduced.contacts is None:  # y are the displacements of the contacts
            mass = reduced.mass + reduced.carried_mass
            M = np.block([[np.eye(omega.size), inertia], [inertia.T, mass]])
            K = np.block([[np.diag(omega**2), spring], [spring.T, reduced.stiffness]])
            contact = list(range(omega.size, len(M)))
            return cls(Structure(M, K, C, contact=contact), shapes)
        springs = omega[:, np.newaxis] ** 2 * inertia
        K = np.block([[np.diag(omega**2), springs], [springs.T, -reduced.stiffness]])
        W = np.vstack((springs - spring, -reduced.stiffness))
        basis = orthonormal(inertia, reduced.carried_mass)
        W = basis.T @ W
        K, C = (basis.T @ matrix @ basis for matrix in (K, C))
        K -= (W * reduced.contacts.reference) @ W.T
        structure = Structure(np.eye(len(W)), 0.5 * (K + K.T), 0.5 * (C + C.T), contact=W)
        return cls(structure, shapes @ basis)
