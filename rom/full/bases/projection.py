"""A structure on the coordinates of its reduced model: the smallest that full order can run on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.full.bases.orthonormal import orthonormal
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.motion import State
from slipmode.rom.reduction.force_response import ForceResponse, Forces
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.matrices import Matrix, as_dense, projection
from slipmode.rom.structure.structure import Structure


@dataclass(frozen=True, eq=False)
class Projection:
    """x = basis c on modes, contact shapes and the static response to forces.

    Retained and nonresonant modes, what contacts do to the structure besides, and what forces do:
    all that the slow flow and its reconstruction have.

    Attributes
    ----------
    structure : Structure
        M = I, K, C, W of the coordinates c.
    basis : (n, coordinates) ndarray
        Orthonormal in the mass of the structure [kg^-1/2].
    to_coordinates : (coordinates, n) ndarray
        c = to_coordinates x [kg^1/2].
    """

    structure: Structure
    basis: Floats
    to_coordinates: Floats

    __repr__ = short_repr

    @classmethod
    def of(cls, structure: Structure, reduced: Reduced, patterns: Forces) -> Self:
        """Of a structure that was reduced, under forces with these patterns."""
        static = ForceResponse.of(reduced, patterns, structure).static
        others = np.hstack((reduced.contact_shapes, static))
        return cls.on(structure, reduced.all_shapes, others)

    @classmethod
    def on(cls, structure: Structure, modes: Floats, others: Floats) -> Self:
        """On M-orthonormal modes (n, k) and whatever other shapes (n, m) have besides."""
        M = structure.mass
        heavy = as_dense(M @ others)
        T = orthonormal(modes.T @ heavy, others.T @ heavy)
        basis = np.hstack((modes, others)) @ T
        gram = basis.T @ as_dense(M @ basis)  # I but for rounding
        basis = np.linalg.solve(np.linalg.cholesky(gram), basis.T).T

        def projected(matrix: Matrix) -> Floats:
            image = projection(basis, matrix, basis)
            return np.asarray(0.5 * (image + image.T))

        small = Structure(
            np.eye(basis.shape[1]),
            projected(structure.stiffness),
            projected(structure.damping),
            contact=basis.T @ as_dense(structure.directions),
        )
        return cls(small, basis, as_dense(M @ basis).T)

    def excitation(self, excitation: Excitation) -> Excitation:
        """The same forces, on the coordinates."""
        return replace(excitation, patterns=excitation.patterns @ self.basis)

    def state(self, state: State) -> State:
        """A state of the structure, on the coordinates."""
        to = self.to_coordinates
        return replace(state, displacement=to @ state.displacement, velocity=to @ state.velocity)
