"""From the structure's matrices to modal coordinates and a contact problem of size N_c."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import ArrayLike, NDArray

from rom.errors import SlipmodeError
from rom.matrices import Floats, Matrix, as_dense
from rom.partition import Partition
from rom.structure import Structure

Formulation = Literal["consistent", "paper"]
Complexes = NDArray[np.complex128]

_DENSE_SIZE = 500  # up to here a dense eigenvalue problem is the faster one


@dataclass(frozen=True, eq=False)
class Reduced:
    """One or two bonded modes coupled to the contact problem.

    x = mode_shapes q + contact_shapes x_c, q_j = a_j exp(i theta_j) + c.c., and
    mass x_c'' + damping x_c' + stiffness x_c + g(x_c') = -2 Re sum_j L_j a_j exp(i theta_j)
    with L_j(nu) = spring_j + i nu damper_j at the frequency nu of the motion.

    Attributes
    ----------
    formulation : {"consistent", "paper"}
    modes : tuple of int
        Indices of the retained bonded modes, by ascending frequency.
    frequency : (modes,) ndarray
        Natural frequencies omega_j of the bonded structure [rad/s].
    carrier : (modes,) ndarray
        Frequencies at which the contact problem is solved [rad/s]: those of the forcing, as far
        as they are known, or the natural frequencies.
    modal_damping : (modes,) ndarray
        phi_j^T C phi_j [1/s].
    mode_shapes : (n, modes) ndarray
        Bonded modes in the structure's DOFs, normalised to unit modal mass [kg^-1/2].
    contact_shapes : (n, N_c) ndarray
        Motion of the structure per unit contact displacement (constraint modes; with residual
        flexibility in the consistent formulation) [-].
    mass, damping, stiffness : (N_c, N_c) ndarray
        Of the contact problem, Eq. (13) [kg], [N s/m], [N/m]. The paper has stiffness alone.
    spring, damper : (modes, N_c) ndarray
        Coupling of the modes to the contacts. The paper has springs alone.
    """

    formulation: Formulation
    modes: tuple[int, ...]
    frequency: Floats
    carrier: Floats
    modal_damping: Floats
    mode_shapes: Floats
    contact_shapes: Floats
    mass: Floats
    damping: Floats
    stiffness: Floats
    spring: Floats
    damper: Floats

    @property
    def coupling(self) -> Complexes:
        """L_j at the carrier of its mode, (modes, N_c)."""
        return self.coupling_at(self.carrier)

    def coupling_at(self, frequency: Floats) -> Complexes:
        """L_j at frequencies nu_j (modes,) [rad/s], (modes, N_c)."""
        nu = np.asarray(frequency)[:, np.newaxis]
        return self.spring + 1j * nu * self.damper

    @property
    def n_dofs(self) -> int:
        """Number of DOFs of the structure."""
        return int(self.mode_shapes.shape[0])

    @property
    def n_contacts(self) -> int:
        """Number of contact DOFs N_c."""
        return int(self.stiffness.shape[0])

    def modal_stiffness(self, frequency: ArrayLike) -> Complexes:
        """omega_j^2 - nu^2 + i gamma_j nu at frequencies nu (...) [rad/s], (..., modes)."""
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis]
        stiffness: Complexes = self.frequency**2 - nu**2 + 1j * self.modal_damping * nu
        return stiffness

    def at_carrier(self, carrier: Sequence[float]) -> Reduced:
        """The same model with its contact problem at other carrier frequencies [rad/s]."""
        frequencies = np.asarray(carrier, dtype=float)
        if frequencies.shape != self.frequency.shape or not np.all(
            np.isfinite(frequencies) & (frequencies > 0)
        ):
            raise SlipmodeError(
                f"carrier: must be {self.frequency.size} finite numbers > 0 [rad/s], got {carrier}"
            )
        return replace(self, carrier=frequencies)

    def modal_force(self, mode: int, force: Mapping[int, float] | ArrayLike) -> float:
        """Modal force phi_j^T f of the `mode`-th retained mode [N kg^-1/2].

        Parameters
        ----------
        mode : int
            0 for mode A, 1 for mode B.
        force : {DOF: amplitude} or (n,) array_like
            Force amplitudes [N].
        """
        return float(self.mode_shapes[:, mode] @ force_vector(force, self.n_dofs))


def force_vector(force: Mapping[int, float] | ArrayLike, n_dofs: int) -> Floats:
    """Force amplitudes (n,) [N] from {DOF: amplitude} or from an array."""
    if isinstance(force, Mapping):
        vector = np.zeros(n_dofs)
        for dof, amplitude in force.items():
            if not 0 <= dof < n_dofs:
                raise SlipmodeError(
                    f"force: DOF {dof} is out of range, allowed: 0 to {n_dofs - 1}"
                )
            vector[dof] = amplitude
    else:
        vector = np.asarray(force, dtype=float)
    if vector.shape != (n_dofs,) or not np.all(np.isfinite(vector)):
        raise SlipmodeError(f"force: must be {n_dofs} finite numbers, one per DOF [N]")
    return vector


def reduce(
    structure: Structure,
    modes: Sequence[int] = (0, 1),
    formulation: Formulation = "consistent",
    carrier: Sequence[float] | None = None,
) -> Reduced:
    """Project a structure on one or two bonded modes and its contacts.

    Parameters
    ----------
    structure : Structure
    modes : sequence of one or two int
        Bonded modes to retain: A, or A and B.
    formulation : {"consistent", "paper"}
        "paper": constraint modes alone, damping and inertia of the contacts neglected,
        Eqs. (13), (20). "consistent": residual flexibility of the modes that are not retained,
        inertia and damping of the contacts, the modes' non-resonant answer to them.
    carrier : sequence of float, optional
        Frequencies at which the contact problem is solved [rad/s], one per mode; the nearer to
        the forcing the better. Default, and always in "paper": the natural frequencies.

    Raises
    ------
    SlipmodeError
        If a mode does not exist, or the bonded structure can move without deforming.
    """
    if formulation not in get_args(Formulation):
        raise SlipmodeError(f"formulation: must be 'consistent' or 'paper', got {formulation!r}")
    modes = tuple(int(mode) for mode in modes)
    parts = structure.partition()
    n_elastic = parts.K_ec.shape[0]
    if len(modes) not in (1, 2) or len(set(modes)) != len(modes):
        raise SlipmodeError(f"modes: must be one or two different modes, got {modes}")
    if not all(0 <= mode < n_elastic for mode in modes):
        raise SlipmodeError(f"modes: must be 0 to {n_elastic - 1}, got {modes}")
    omega, phi = bonded_modes(parts, max(modes) + 1)
    omega, phi = omega[list(modes)], phi[:, list(modes)]
    mode_shapes = as_dense(parts.E @ phi)
    constraint_modes = as_dense(parts.R - parts.E @ _solve(parts.K_ee, parts.K_ec))
    if formulation == "paper":
        return _reduce_paper(parts, modes, omega, phi, constraint_modes)
    reduced = _reduce_consistent(structure, modes, omega, mode_shapes, constraint_modes)
    return reduced if carrier is None else reduced.at_carrier(carrier)


def bonded_modes(parts: Partition, count: int) -> tuple[Floats, Floats]:
    """Lowest natural frequencies (count,) and modes (n_e, count) with stuck contacts, Eq. (8).

    Mass-normalised; the largest component of each mode is positive.
    """
    size = parts.K_ec.shape[0]
    if not scipy.sparse.issparse(parts.K_ee) or size <= _DENSE_SIZE or count >= size - 1:
        squares, phi = scipy.linalg.eigh(
            as_dense(parts.K_ee), as_dense(parts.M_ee), subset_by_index=(0, count - 1)
        )
    else:
        try:
            squares, phi = scipy.sparse.linalg.eigsh(
                parts.K_ee, k=count, M=parts.M_ee, sigma=0.0, v0=np.ones(size)
            )
        except RuntimeError as error:
            raise SlipmodeError(_RIGID) from error
    stiffest = parts.K_ee.diagonal().max() / parts.M_ee.diagonal().max()
    if squares[0] <= 1e-12 * stiffest:
        raise SlipmodeError(_RIGID)
    phi = phi * np.sign(phi[np.argmax(np.abs(phi), axis=0), np.arange(count)])
    return np.sqrt(squares), phi


_RIGID = (
    "stiffness: must be positive definite with stuck contacts, but the bonded structure has a "
    "rigid-body mode; fix a DOF or add a contact"
)


def _reduce_paper(
    parts: Partition, modes: tuple[int, ...], omega: Floats, phi: Floats, constraint_modes: Floats
) -> Reduced:
    """Eqs. (13) and (20): K_xx = K_cc - K_ce K_ee^-1 K_ec, coupling K_ce phi, and no more."""
    nothing = np.zeros_like(parts.K_cc)
    spring = phi.T @ parts.K_ec
    return Reduced(
        formulation="paper",
        modes=modes,
        frequency=omega,
        carrier=omega,
        modal_damping=np.diag(phi.T @ as_dense(parts.C_ee @ phi)).copy(),
        mode_shapes=as_dense(parts.E @ phi),
        contact_shapes=constraint_modes,
        mass=nothing,
        damping=nothing,
        stiffness=_symmetric(parts.K_cc - parts.K_ec.T @ _solve(parts.K_ee, parts.K_ec)),
        spring=spring,
        damper=np.zeros_like(spring),
    )


def _reduce_consistent(
    structure: Structure,
    modes: tuple[int, ...],
    omega: Floats,
    Phi: Floats,
    constraint_modes: Floats,
) -> Reduced:
    """Constraint modes made M-orthogonal to the retained modes.

    What the retained modes carry statically is then not counted twice (residual flexibility),
    and they couple to the contacts through stiffness and damping alone.
    """
    M, C, K = structure.mass, structure.damping, structure.stiffness
    X = constraint_modes - Phi @ (Phi.T @ as_dense(M @ constraint_modes))
    return Reduced(
        formulation="consistent",
        modes=modes,
        frequency=omega,
        carrier=omega,
        modal_damping=np.diag(Phi.T @ as_dense(C @ Phi)).copy(),
        mode_shapes=Phi,
        contact_shapes=X,
        mass=_symmetric(X.T @ as_dense(M @ X)),
        damping=_symmetric(X.T @ as_dense(C @ X)),
        stiffness=_symmetric(X.T @ as_dense(K @ X)),
        spring=Phi.T @ as_dense(K @ X),
        damper=Phi.T @ as_dense(C @ X),
    )


def _solve(K_ee: Matrix, right: Floats) -> Floats:
    if scipy.sparse.issparse(K_ee):
        return np.asarray(scipy.sparse.linalg.splu(K_ee.tocsc()).solve(right))
    return np.asarray(scipy.linalg.solve(K_ee, right, assume_a="pos"))


def _symmetric(matrix: Floats) -> Floats:
    return 0.5 * (matrix + matrix.T)
