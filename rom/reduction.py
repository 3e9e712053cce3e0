"""From the structure's matrices to modal coordinates and a contact problem of size N_c."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
    damping x_c' + stiffness x_c + g(x_c') = -2 Re sum_j coupling_j a_j exp(i theta_j).

    Attributes
    ----------
    formulation : {"consistent", "paper"}
    modes : tuple of int
        Indices of the retained bonded modes, by ascending frequency.
    frequency : (modes,) ndarray
        Natural frequencies omega_j of the bonded structure [rad/s].
    modal_damping : (modes,) ndarray
        phi_j^T C phi_j [1/s].
    mode_shapes : (n, modes) ndarray
        Bonded modes in the structure's DOFs, normalised to unit modal mass [kg^-1/2].
    contact_shapes : (n, N_c) ndarray
        Motion of the structure per unit contact displacement (constraint modes; with residual
        flexibility in the consistent formulation).
    stiffness, damping : (N_c, N_c) ndarray
        Of the contact problem, Eq. (13) [N/m], [N s/m].
    coupling : (modes, N_c) complex ndarray
        Force on the contacts per unit modal amplitude at the natural frequency.
    """

    formulation: Formulation
    modes: tuple[int, ...]
    frequency: Floats
    modal_damping: Floats
    mode_shapes: Floats
    contact_shapes: Floats
    stiffness: Floats
    damping: Floats
    coupling: Complexes

    @property
    def n_dofs(self) -> int:
        """Number of DOFs of the structure."""
        return int(self.mode_shapes.shape[0])

    @property
    def n_contacts(self) -> int:
        """Number of contact DOFs N_c."""
        return int(self.stiffness.shape[0])

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
        damping on the contacts, inertial coupling at the mode's own frequency.

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
    constraint_modes = -_solve(parts.K_ee, parts.K_ec)
    if formulation == "paper":
        return _reduce_paper(parts, modes, omega, phi, constraint_modes)
    return _reduce_consistent(parts, modes, omega, phi, constraint_modes)


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
    parts: Partition, modes: tuple[int, ...], omega: Floats, phi: Floats, psi: Floats
) -> Reduced:
    """Eqs. (13) and (20): K_xx = K_cc - K_ce K_ee^-1 K_ec, coupling K_ce phi."""
    return Reduced(
        formulation="paper",
        modes=modes,
        frequency=omega,
        modal_damping=_modal(phi, parts.C_ee),
        mode_shapes=as_dense(parts.E @ phi),
        contact_shapes=as_dense(parts.E @ psi + parts.R),
        stiffness=_symmetric(parts.K_cc + parts.K_ec.T @ psi),
        damping=np.zeros_like(parts.K_cc),
        coupling=(phi.T @ parts.K_ec).astype(complex),
    )


def _reduce_consistent(
    parts: Partition, modes: tuple[int, ...], omega: Floats, phi: Floats, psi: Floats
) -> Reduced:
    """Residual flexibility: what the retained modes carry statically is not counted twice."""
    psi_r = psi + phi @ ((phi.T @ parts.K_ec) / omega[:, np.newaxis] ** 2)
    damping_to_contact = parts.C_ec.T + psi_r.T @ parts.C_ee
    spring = phi.T @ parts.K_ec
    damper = (damping_to_contact @ phi).T
    inertia = phi.T @ parts.M_ec
    squares = omega[:, np.newaxis] ** 2
    return Reduced(
        formulation="consistent",
        modes=modes,
        frequency=omega,
        modal_damping=_modal(phi, parts.C_ee),
        mode_shapes=as_dense(parts.E @ phi),
        contact_shapes=as_dense(parts.E @ psi_r + parts.R),
        stiffness=_symmetric(parts.K_cc + parts.K_ec.T @ psi_r),
        damping=_symmetric(parts.C_cc + psi_r.T @ parts.C_ec + damping_to_contact @ psi_r),
        coupling=spring - squares * inertia + 1j * omega[:, np.newaxis] * damper,
    )


def _modal(phi: Floats, matrix: Matrix) -> Floats:
    """phi_j^T matrix phi_j for every column."""
    product: Floats = np.einsum("ij,ij->j", phi, as_dense(matrix @ phi))
    return product


def _solve(K_ee: Matrix, right: Floats) -> Floats:
    if scipy.sparse.issparse(K_ee):
        return np.asarray(scipy.sparse.linalg.splu(K_ee.tocsc()).solve(right))
    return np.asarray(scipy.linalg.solve(K_ee, right, assume_a="pos"))


def _symmetric(matrix: Floats) -> Floats:
    return 0.5 * (matrix + matrix.T)
