"""Structures that full order runs on in place of a large one, or with aerodynamic forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.motion import State
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import Matrix, as_dense, projection
from slipmode.rom.structure.structure import Structure


@frozen
class Projection:
    """A structure on the coordinates c of a basis, x = basis c."""

    structure: Structure  # M = I, K, C, W of the coordinates
    basis: Floats  # (n, coordinates), orthonormal in the mass of the structure [kg^-1/2]
    to_coordinates: Floats  # (coordinates, n), c = to_coordinates x [kg^1/2]

    @classmethod
    def of(cls, structure: Structure, reduced: Reduced, patterns: Forces) -> Self:
        """Project on all shapes of the reduced model: modes, contact shapes, static responses.

        `patterns` are the patterns of the forces.
        """
        static = AppliedForces.of(reduced, patterns, structure).static
        others = np.hstack((reduced.contact_shapes, static))
        return cls.on(structure, reduced.all_shapes, others)

    @classmethod
    def on(cls, structure: Structure, modes: Floats, others: Floats) -> Self:
        """Project on M-orthonormal modes (n, k) and the independent parts of shapes (n, m)."""
        M = structure.mass
        inertia = as_dense(M @ others)
        T = orthonormal(modes.T @ inertia, others.T @ inertia)
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
        """Return an excitation of the structure on the coordinates."""
        return replace(excitation, patterns=excitation.patterns @ self.basis)

    def state(self, state: State) -> State:
        """Return a state of the structure on the coordinates."""
        to = self.to_coordinates
        return replace(state, displacement=to @ state.displacement, velocity=to @ state.velocity)


@frozen
class ReducedStructure:
    """The structure of a reduced model, x = shapes c, with the modes first in c."""

    structure: Structure  # M, K, C, W of the coordinates, without springs of elastic contacts
    shapes: Floats  # (n, coordinates) [kg^-1/2]

    @classmethod
    def of(cls, reduced: Reduced) -> Self:
        """Return the structure of a consistent reduced model.

        M, K and C on the shapes (Phi, X) of x = Phi q + X y are in its coupling. With elastic
        contacts K is K_s, with their springs, and X its static response to forces on them.
        """
        omega = np.append(reduced.structural_frequency, reduced.nonresonant_frequency)
        spring, inertia, damper = reduced.coupling_parts
        structural = reduced.modal_damping - reduced.aerodynamic_damping
        own = np.diag(np.append(structural, reduced.nonresonant_damping))
        C = np.block([[own + reduced.damping_coupling, damper], [damper.T, reduced.damping]])
        shapes = np.hstack((reduced.all_shapes, reduced.contact_shapes))
        if reduced.contacts is None:  # y are the displacements of the contacts
            mass = reduced.mass + reduced.carried_mass
            M = np.block([[np.eye(omega.size), inertia], [inertia.T, mass]])
            K = np.block([[np.diag(omega**2), spring], [spring.T, reduced.stiffness]])
            structure = Structure(M, K, C, contact=list(range(omega.size, len(M))))
            return cls(aeroelastic(structure, reduced, np.eye(len(M), len(reduced.modes))), shapes)
        springs = omega[:, np.newaxis] ** 2 * inertia
        K = np.block([[np.diag(omega**2), springs], [springs.T, -reduced.stiffness]])
        basis = orthonormal(inertia, reduced.carried_mass)
        W = basis.T @ np.vstack((springs - spring, -reduced.stiffness))
        K, C = (basis.T @ matrix @ basis for matrix in (K, C))
        K -= (W * reduced.contacts.reference) @ W.T
        unit = np.eye(len(W))
        structure = Structure(unit, 0.5 * (K + K.T), 0.5 * (C + C.T), contact=W)
        structure = aeroelastic(structure, reduced, unit[:, : len(reduced.modes)])
        return cls(structure, shapes @ basis)


def orthonormal(inertia: Floats, mass: Floats) -> Floats:
    """Return T (modes + shapes, coordinates) for which [Phi X] T is orthonormal in M.

    The first coordinates are the modes Phi, Phi^T M Phi = I, unchanged; the others are the
    independent parts of the shapes X, beyond rounding. `inertia` is Phi^T M X, `mass` X^T M X.
    """
    modes, shapes = inertia.shape
    scale = np.sqrt(np.maximum(np.diag(mass), np.finfo(float).tiny))
    size, mixed = np.linalg.eigh((mass - inertia.T @ inertia) / np.outer(scale, scale))
    # Smaller independent parts of unit shapes are rounding
    own = size > 1e-10
    others = mixed[:, own] / np.sqrt(size[own]) / scale[:, np.newaxis]
    return np.block([[np.eye(modes), -inertia @ others], [np.zeros((shapes, modes)), others]])


def aeroelastic(
    structure: Structure, reduced: Reduced, mode_shapes: Floats | None = None
) -> Structure:
    """Return the structure with the aerodynamic forces of its reduced model.

    Each mode phi adds M phi Re(c) phi^T M to the stiffness. It adds M phi Im(c) / omega phi^T M to
    the damping, with the natural frequency omega of the structure alone. The result may be
    self-excited.

    Parameters
    ----------
    structure : Structure
        Structure without aerodynamics.
    reduced : Reduced
        Reduced model of this structure. Without `aerodynamics` the structure is returned
        unchanged.
    mode_shapes : (n, modes) ndarray, optional
        Retained modes in the coordinates of `structure` [kg^-1/2]. Default: `reduced.mode_shapes`.

    Returns
    -------
    Structure
        Structure with additional stiffness and damping, dense.
    """
    c = reduced.aerodynamics
    if c is None:
        return structure
    shapes = reduced.mode_shapes if mode_shapes is None else mode_shapes
    along = as_dense(structure.mass @ shapes)
    return structure.with_forces(
        (along * c.real) @ along.T, (along * reduced.aerodynamic_damping) @ along.T
    )
