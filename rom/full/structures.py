"""Structures that full order runs on in place of a large one, or with aerodynamic forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.motion import State
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.reduction.nonlinear.stiffness import refuse_nonlinear_stiffness
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.reduction.structural_damping import without_loss
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import Matrix, as_dense, projection
from slipmode.rom.structure.structure import Structure


@frozen
class Projection:
    """A structure on the coordinates c of a basis, x = basis c."""

    structure: Structure  # M, K, C, W of the coordinates; M is 1 or, without inertia, 0
    basis: Floats  # (n, coordinates) [kg^-1/2]
    to_coordinates: Floats  # (coordinates, n), c = to_coordinates x [kg^1/2]

    @classmethod
    def of(cls, structure: Structure, reduced: Reduced, patterns: Forces) -> Self:
        """Project on all shapes of the reduced model: modes, contact shapes, static responses.

        `patterns` are the patterns of the forces.
        """
        static = AppliedForces.of(reduced, patterns, structure).static
        others = np.hstack((reduced.contact_shapes, static))
        return cls.on(structure, reduced.all_shapes, others, reduced.highest_frequency)

    @classmethod
    def on(cls, structure: Structure, modes: Floats, others: Floats, highest: float) -> Self:
        """Project on M-orthonormal modes (n, k) and the independent parts of shapes (n, m).

        `highest` is the highest frequency of the modes [rad/s].
        """
        M, K = structure.mass, structure.stiffness
        inertia = modes.T @ as_dense(M @ others)
        rest = others - modes @ inertia
        whole, parts = (
            (projection(each, M, each), projection(each, K, each)) for each in (others, rest)
        )
        T, light = independent(parts, whole, highest)
        basis = np.hstack((modes, rest @ T))
        mass = np.ones(basis.shape[1])
        mass[modes.shape[1] :][light] = 0.0
        moving = mass > 0.0
        gram = projection(basis[:, moving], M, basis[:, moving])  # I but for rounding
        basis[:, moving] = np.linalg.solve(np.linalg.cholesky(gram), basis[:, moving].T).T

        def projected(matrix: Matrix) -> Floats:
            image = projection(basis, matrix, basis)
            return np.asarray(0.5 * (image + image.T))

        K_small = projected(K)
        W = basis.T @ as_dense(structure.directions)
        loss = 0.0 if structure.loss is None else 1j * projected(structure.loss)
        small = Structure(np.diag(mass), K_small + loss, contact=W)
        small = small.with_forces(np.zeros_like(K_small), projected(structure.damping))
        to_coordinates = as_dense(M @ basis).T
        if light.any():  # their part of the rest is K-orthogonal to the statically following one
            static = basis[:, ~moving].T
            across = as_dense(K @ static.T).T
            of_rest = across - K_small[~moving][:, moving] @ to_coordinates[moving]
            to_coordinates[~moving] = np.linalg.solve(K_small[~moving][:, ~moving], of_rest)
        return cls(small, basis, to_coordinates)

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
        reduced, loss = without_loss(reduced)
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
            contacts = list(range(omega.size, len(M)))
            structure = Structure(M, K + 1j * loss, C, contact=contacts)
            return cls(aeroelastic(structure, reduced, np.eye(len(M), len(reduced.modes))), shapes)
        # Shapes X' = X - Phi inertia are orthogonal to the modes in M and K_s
        stiffness = -reduced.stiffness - inertia.T @ (omega[:, np.newaxis] ** 2 * inertia)
        mass = reduced.carried_mass - inertia.T @ inertia
        whole = reduced.carried_mass, -reduced.stiffness
        own, light = independent((mass, stiffness), whole, reduced.highest_frequency)
        T = np.block(
            [[np.eye(omega.size), -inertia @ own], [np.zeros((len(own), omega.size)), own]]
        )
        springs = omega[:, np.newaxis] ** 2 * inertia
        K = T.T @ np.block([[np.diag(omega**2), springs], [springs.T, -reduced.stiffness]]) @ T
        W = T.T @ np.vstack((springs - spring, -reduced.stiffness))
        K -= (W * reduced.contacts.reference) @ W.T
        unit = np.eye(len(W))
        M = np.diag(np.append(np.ones(omega.size), np.where(light, 0.0, 1.0)))
        K, C, loss = 0.5 * (K + K.T), T.T @ C @ T, T.T @ loss @ T
        structure = Structure(M, K + 0.5j * (loss + loss.T), contact=W)
        structure = structure.with_forces(np.zeros_like(K), 0.5 * (C + C.T))
        structure = aeroelastic(structure, reduced, unit[:, : len(reduced.modes)])
        return cls(structure, shapes @ T)


def independent(
    parts: tuple[Floats, Floats], whole: tuple[Floats, Floats], highest: float
) -> tuple[Floats, Flags]:
    """Return the independent parts T (m, k) of shapes, and which of them have no inertia (k,).

    `whole` is mass and stiffness (m, m) of the shapes, `parts` of their parts orthogonal to the
    modes. Parts with inertia are orthonormal in the mass. Parts whose frequency is above 1e5 times
    `highest` [rad/s] have none beyond rounding.
    """
    (mass, stiffness), (whole_mass, whole_stiffness) = parts, whole
    unit = np.diag(whole_stiffness + highest**2 * whole_mass)
    scale = np.sqrt(np.maximum(unit, np.finfo(float).tiny))
    size, mixed = np.linalg.eigh((stiffness + highest**2 * mass) / np.outer(scale, scale))
    # Smaller independent parts of unit shapes are rounding
    own = size > 1e-10
    T = mixed[:, own] / np.sqrt(size[own]) / scale[:, np.newaxis]
    inertia, mixed = np.linalg.eigh(T.T @ mass @ T)
    T = T @ mixed
    light = highest**2 * inertia <= 1e-10
    T[:, ~light] /= np.sqrt(inertia[~light])
    return T, light


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
    refuse_nonlinear_stiffness(reduced, "full order", "compare without coefficients")
    c = reduced.aerodynamics
    if c is None:
        return structure
    shapes = reduced.mode_shapes if mode_shapes is None else mode_shapes
    along = as_dense(structure.mass @ shapes)
    return structure.with_forces(
        (along * c.real) @ along.T, (along * reduced.aerodynamic_damping) @ along.T
    )
