"""A structure with dry-friction contacts: its matrices, validated once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats, in_one_line
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.representable import SMALLEST
from slipmode.rom.storage.files import as_path
from slipmode.rom.structure.damping import LossFactor, Rayleigh
from slipmode.rom.structure.files import read_matrices, write_npz
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.matrices import (
    Matrix,
    MatrixLike,
    Sparse,
    as_csc,
    as_dense,
    as_symmetric,
    real_and_imaginary,
)
from slipmode.rom.structure.partition import Partition, contact_directions
from slipmode.rom.structure.solvers.factorisation import NotPositiveDefiniteError, factorise
from slipmode.rom.structure.solvers.mass import is_positive_semidefinite, massless_motions


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Structure:
    """Represent a linear structure and its contact directions, source Eq. (1).

    The equation of motion is M x'' + C x' + K x + W g = f. A contact law gives the contact
    forces g (N_c,) [N] from the contact displacements x_c = W^T x (N_c,) [m]. The structure does
    not contain the law.

    Parameters
    ----------
    mass : (n, n) array or sparse matrix
        Mass matrix M [kg], symmetric and positive semidefinite. Motions without inertia, such as
        DOFs with rows of zeros, follow the others statically, which is exact.
    stiffness : (n, n) array or sparse matrix
        Stiffness matrix K [N/m] without the contacts, symmetric. The imaginary part of a complex
        matrix is structural damping K''. Rigid-body modes are allowed.
        `rom.reduce` refuses rigid-body modes that remain with bonded contacts (Tanh, Coulomb).
        Rigid-body modes that remain with the springs of elastic contacts cannot be retained.
    damping : float, Rayleigh, LossFactor, or (n, n) array or sparse matrix, default 0.0
        A number is beta [s] of C = beta K. `Rayleigh` stands for C = alpha M + beta K. A matrix is
        C [N s/m] itself, symmetric and positive semidefinite. `LossFactor` stands for structural
        damping K'' = eta K.
    contact : sequence of int, or (n, N_c) array or sparse matrix
        Indices of the contact DOFs, or the matrix W [-] of contact directions, 1 <= N_c <= n.
        A column of W with entries +1 and -1 is the relative displacement of two nodes. No two
        columns may be parallel. For rigid laws (Tanh, Coulomb) all columns must be linearly
        independent.
    labels : Labels, optional
        Node and direction of each DOF.

    Attributes
    ----------
    mass, stiffness, damping : (n, n) matrix
        M [kg], K [N/m] and C [N s/m]: read-only ndarrays, or CSC arrays if mass or stiffness was
        sparse.
    beta : float or None
        Factor beta [s] of C = beta K. None for any other damping.
    directions : (n, N_c) matrix
        Contact directions W [-], dense or CSC like the other matrices.
    labels : Labels or None
        Node and direction of each DOF.
    loss : (n, n) matrix or None
        Structural damping K'' [N/m]: the force i K'' x at each frequency. Reduced models and full
        order have the equivalent viscous damping K'' / Omega at the carrier Omega, and at the
        natural frequency for modes without a carrier.
    massless : (n, m) CSC array
        Orthonormal basis Z [-] of the motions without inertia, M Z = 0.

    Raises
    ------
    SlipmodeError
        If a matrix has a wrong shape, is not symmetric, or is not finite. If the mass matrix is
        or damping matrix is not positive semidefinite. If a motion without inertia has no
        stiffness, or other damping than alpha M + beta K.

    Examples
    --------
    One mass on a spring, with a friction contact between the mass and the ground:

    >>> rom.Structure([[1.0]], [[4.0]], rom.Rayleigh.from_ratios(0.01, 2.0), contact=[0])
    Structure(1 DOFs, 1 contacts, dense)
    """

    mass: Matrix
    stiffness: Matrix
    beta: float | None
    directions: Matrix
    labels: Labels | None
    massless: Sparse
    _damping: Matrix | Rayleigh
    _loss: Matrix | LossFactor | None

    def __init__(
        self,
        mass: MatrixLike,
        stiffness: MatrixLike,
        damping: float | Rayleigh | LossFactor | MatrixLike = 0.0,
        *,
        contact: MatrixLike,
        labels: Labels | None = None,
    ) -> None:
        M = as_symmetric("mass", mass)
        Z = massless_motions(M)
        if Z is None:
            raise SlipmodeError(
                "mass: must be positive definite, except for DOFs without mass (rows of zeros) "
                "and other motions x with M x = 0"
            )
        diagonal = M.diagonal()
        if diagonal[diagonal > 0.0].min() < SMALLEST:
            raise SlipmodeError(
                f"mass: every DOF needs at least {SMALLEST:g}, or none; use other units"
            )
        real, imaginary = real_and_imaginary(stiffness)
        K = as_symmetric("stiffness", real, M.shape[0])
        loss = _checked_loss(imaginary, damping, M.shape[0])
        C = checked_damping(0.0 if isinstance(damping, LossFactor) else damping, M.shape[0])
        if labels is not None and labels.node.size != M.shape[0]:
            raise SlipmodeError(f"labels: must be {M.shape[0]}, got {labels.node.size}")
        W = contact_directions(contact, M.shape[0])
        if Z.shape[1]:
            _check_massless(Z, K, C)
        is_dense = isinstance(M, np.ndarray) and isinstance(K, np.ndarray)
        store: Callable[[Matrix], Matrix] = _read_only if is_dense else as_csc
        _set(
            self,
            mass=store(M),
            stiffness=store(K),
            beta=C.beta if isinstance(C, Rayleigh) and C.alpha == 0.0 else None,
            directions=store(W),
            labels=labels,
            massless=Z,
            _damping=C if isinstance(C, Rayleigh) else store(C),
            _loss=loss if loss is None or isinstance(loss, LossFactor) else store(loss),
        )

    def __repr__(self) -> str:
        storage = "dense" if isinstance(self.mass, np.ndarray) else "sparse"
        return f"Structure({self.n_dofs} DOFs, {self.n_contacts} contacts, {storage})"

    @property
    def n_dofs(self) -> int:
        """Number n of degrees of freedom."""
        return int(self.mass.shape[0])

    @property
    def n_contacts(self) -> int:
        """Number N_c of contact DOFs, the columns of W."""
        return int(self.directions.shape[1])

    @property
    def n_modes(self) -> int:
        """Number of modes with free contacts: DOFs less motions without inertia."""
        return self.n_dofs - int(self.massless.shape[1])

    def with_forces(self, stiffness: Floats, damping: Floats) -> Structure:
        """Return the structure with additional linear forces -K_e x - C_e x'.

        Parameters
        ----------
        stiffness : (n, n) ndarray
            Additional stiffness K_e [N/m], symmetric. It need not be positive.
        damping : (n, n) ndarray
            Additional damping C_e [N s/m], symmetric. It may supply energy to the structure.

        Returns
        -------
        Structure
            Structure with the matrices K + K_e and C + C_e, stored dense.
        """
        other = copy(self)
        _set(
            other,
            mass=_read_only(self.mass),
            stiffness=_read_only(as_dense(self.stiffness) + stiffness),
            _damping=_read_only(as_dense(self.damping) + damping),
            _loss=None if self.loss is None else _read_only(self.loss),
            directions=_read_only(self.directions),
            beta=None,
        )
        return other

    @property
    def damping(self) -> Matrix:
        """Damping matrix C (n, n) [N s/m].

        The matrix alpha M + beta K of `Rayleigh` is computed again at each access.
        """
        given = self._damping
        if not isinstance(given, Rayleigh):
            return given
        C: Any = self.stiffness * given.beta
        if given.alpha:
            C = C + self.mass * given.alpha
        return _read_only(C) if isinstance(C, np.ndarray) else C

    @property
    def loss(self) -> Matrix | None:
        """Structural damping K'' (n, n) [N/m]; for `LossFactor` computed at each access."""
        if not isinstance(self._loss, LossFactor):
            return self._loss
        loss: Any = self.stiffness * self._loss.eta
        return _read_only(loss) if isinstance(loss, np.ndarray) else loss

    def partition(self) -> Partition:
        """Return the matrices in elastic and contact coordinates, source Eq. (3).

        Returns
        -------
        Partition
            Blocks M_ee, M_ec, M_cc and the corresponding blocks of C and K.
        """
        return Partition.of(self.mass, self.damping, self.stiffness, self.directions)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the structure to a .npz file.

        `load_structure` reads the file back without rounding.

        Parameters
        ----------
        path : path
            Name of the file, which ends in .npz.

        Raises
        ------
        SlipmodeError
            If the name has another ending, or the file cannot be written.
        """
        loss: Any = self.loss
        matrices: dict[str, Any] = {
            "mass": self.mass,
            "stiffness": self.stiffness if loss is None else self.stiffness + 1j * loss,
            "damping": self.damping if self.beta is None else self.beta,
            "contact": self.directions,
        }
        if self.labels is not None:
            matrices["labels"] = self.labels.table
        write_npz(Path(path), matrices)


def load_structure(
    path: str | PathLike[str],
    damping: float | Rayleigh | LossFactor | MatrixLike | None = None,
    *,
    mass: str | PathLike[str] | None = None,
    contact: MatrixLike | Sequence[Sequence[Any]] | None = None,
    names: Mapping[str, str] | None = None,
) -> Structure:
    """Read a structure from a file of slipmode or of a finite element program.

    Parameters
    ----------
    path : path
        One of the following:

        - A .npz file with the arrays mass, stiffness and optionally contact (DOF indices or W)
          and damping (C, or the number beta). A sparse matrix is stored in CSR form as mass_data,
          mass_indices, mass_indptr and mass_shape.
        - A folder with the Matrix Market files mass.mtx, stiffness.mtx and optionally
          damping.mtx. Contacts are in contact.mtx (W) or contact.txt (indices).
        - A file with the stiffness alone: .mtx of Matrix Market or Abaqus (*MATRIX GENERATE),
          .sti of CalculiX, Harwell-Boeing (.hb, .rsa, .rua, .matrix), for instance of Ansys, .npy
          of NumPy, or .npz of scipy.sparse.
        - A file with all matrices: .mtx of Abaqus (*SUBSTRUCTURE MATRIX OUTPUT); .mat of MATLAB
          or .npz, with variables such as K and M, also in structs (version 7.3 needs
          `slipmode[matlab]`); .op4 or .pch of Nastran with KGG, MGG, and so on; .full of Ansys
          (needs `slipmode[ansys]`).
    damping : float, Rayleigh, LossFactor or (n, n) matrix, optional
        Damping as of `Structure`. Default: the damping in the file, or none. It includes
        structural damping, by a complex stiffness or matrices such as K4GG of Nastran.
    mass : path, optional
        File of the mass matrix, if it is separate. For Abaqus (JOB_STIF1.mtx) and CalculiX (.sti)
        the default is the mass file of the job, JOB_MASS1.mtx or .mas.
    contact : as of Structure, or sequence of tuple, optional
        Contacts instead of the contacts in the file. Tuples are (node, direction) for an absolute
        displacement, or (node, other node, direction) for a relative one. Node numbers belong to
        the finite element program. Directions are "x", "y", "z", "rx", "ry" and "rz".
    names : {"mass", "stiffness", "damping", "contact": str}, optional
        Names of matrices in a file with several, for instance {"stiffness": "sys.K"}. Default:
        names that begin with M, K, and B, C or D, of square matrices of one size.

    Returns
    -------
    Structure
        Structure with the matrices of the file, and with `labels` if the file has node numbers.

    Raises
    ------
    SlipmodeError
        If the file cannot be read, contacts are missing, a node is not in the file, or a matrix is
        refused by `Structure`.

    Examples
    --------
    Matrices of Abaqus, with one friction contact between two nodes along x::

        structure = rom.load_structure("job_STIF1.mtx", damping=1e-6, contact=[(12, 47, "x")])
    """
    file = as_path("path", path)
    if names is not None and not (
        isinstance(names, Mapping) and all(isinstance(name, str) for name in names.values())
    ):
        raise SlipmodeError(
            f'names: must be such as {{"stiffness": "K", "mass": "M"}}, got {in_one_line(names)}'
        )
    given = [
        part for part, value in (("damping", damping), ("contact", contact)) if value is not None
    ]
    matrices = read_matrices(file, None if mass is None else as_path("mass", mass), names, given)
    if damping is not None:
        matrices["damping"] = damping
    with naming(path):
        if contact is not None:
            matrices["contact"] = _labelled(contact, matrices.get("labels"))
        if "contact" not in matrices:
            raise SlipmodeError(
                'contact: is missing; give contact=, as DOF indices, W or [(node, "x"), ...]'
            )
        empty = matrices.pop("empty", [])
        structure = Structure(**matrices)
        touched = np.intersect1d(as_csc(structure.directions).indices, empty)
        if touched.size:
            raise SlipmodeError(
                f"contact: DOF {touched[0]} has neither mass nor stiffness; give another DOF"
            )
        return structure


def _labelled(contact: Any, labels: Labels | None) -> Any:
    """Return contacts as given, or W of contacts that are named by nodes."""
    named = isinstance(contact, list | tuple) and any(
        isinstance(each, list | tuple) and any(isinstance(word, str) for word in each)
        for each in contact
    )
    if not named:
        return contact
    if labels is None:
        raise SlipmodeError("contact: the file names no nodes; give DOF indices or W")
    return labels.directions(contact)


def two_mass(
    beta: float = 0.01,
    contact_mass: float = 0.01,
    *,
    m1: float = 1.0,
    m2: float = 1.0,
    k1: float = 1.0,
    k2: float = 1.7**2,
    k_c1: float = 20.0,
    k_c2: float = 40.0,
    k_p: float = 5.0,
) -> Structure:
    """Return the two-mass structure of source Eq. (26), with the values of Table 1.

    Two modal masses are connected to a common friction contact. The DOFs are x_e1, x_e2, x_c1 and
    x_c2; the last two are the contact DOFs. The natural frequencies with bonded contact are
    sqrt(k1 / m1) = 1 rad/s and sqrt(k2 / m2) = 1.7 rad/s.

    Parameters
    ----------
    beta : float, default 0.01
        Factor of stiffness-proportional damping, C = beta K [s].
    contact_mass : float, default 0.01
        Mass of each contact DOF [kg], positive.
    m1, m2 : float, default 1.0
        Modal masses [kg], positive.
    k1, k2 : float, default 1.0 and 2.89
        Stiffness between each modal mass and its contact DOF [N/m].
    k_c1, k_c2 : float, default 20.0 and 40.0
        Stiffness between each contact DOF and the ground [N/m].
    k_p : float, default 5.0
        Off-diagonal stiffness between the contact DOFs, with the sign of source Eq. (26) [N/m].

    Returns
    -------
    Structure
        Structure with n = 4 DOFs and N_c = 2 contact DOFs.
    """
    mass = np.diag([m1, m2, contact_mass, contact_mass])
    stiffness = np.array(
        [
            [k1, 0.0, -k1, 0.0],
            [0.0, k2, 0.0, -k2],
            [-k1, 0.0, k1 + k_c1, k_p],
            [0.0, -k2, k_p, k2 + k_c2],
        ]
    )
    return Structure(mass, stiffness, beta, contact=(2, 3))


def checked_damping(
    damping: float | Rayleigh | LossFactor | MatrixLike, size: int
) -> Matrix | Rayleigh:
    """Return C, or how it follows from mass and stiffness."""
    if isinstance(damping, Rayleigh):
        return damping
    if isinstance(damping, LossFactor):
        raise SlipmodeError(
            "damping: a loss factor is not for bladed disks; use rom.Rayleigh.from_loss_factor"
        )
    if isinstance(damping, float | int | np.floating):
        return Rayleigh(0.0, float(damping))
    C = as_symmetric("damping", damping, size)
    if not is_positive_semidefinite(C, "damping"):
        raise SlipmodeError("damping: must be positive semidefinite (it must not add energy)")
    return C


def _checked_loss(
    imaginary: MatrixLike | None, damping: object, size: int
) -> Matrix | LossFactor | None:
    """Return the structural damping, of the imaginary part of the stiffness or a loss factor."""
    if imaginary is None:
        return damping if isinstance(damping, LossFactor) else None
    if isinstance(damping, LossFactor):
        raise SlipmodeError("damping: leave the loss factor out; the complex stiffness has one")
    loss = as_symmetric("stiffness: the imaginary part", imaginary, size)
    if not is_positive_semidefinite(loss, "stiffness"):
        raise SlipmodeError(
            "stiffness: the imaginary part must be positive semidefinite (it must not add energy)"
        )
    return loss


def _check_massless(Z: Sparse, K: Matrix, C: Matrix | Rayleigh) -> None:
    """Refuse motions without inertia, Z (n, m), that do not follow the others statically.

    Without forces, x - Z (Z^T K Z)^-1 Z^T K x solves the equation of motion along Z if the forces
    of C are 0 there for such motions, as with C = alpha M + beta K.
    """
    dof = as_csc(abs(Z)).argmax(axis=0)  # a unit motion, or the largest part of another motion
    forces = as_csc(K @ Z)
    empty = np.diff(forces.indptr) == 0
    if empty.any():
        raise SlipmodeError(
            f"mass, stiffness: DOF {dof[empty][0]} has neither mass nor stiffness; leave it out, "
            "or give it stiffness"
        )
    try:
        factors = factorise(as_csc(Z.T @ forces))
    except NotPositiveDefiniteError:
        raise SlipmodeError(
            f"stiffness: must be positive definite on the {dof.size} DOFs without mass, or some "
            "of them move without resistance; give them mass or stiffness"
        ) from None
    if isinstance(C, Rayleigh):
        return
    motion = np.random.default_rng(0).standard_normal(Z.shape[0])
    motion -= np.asarray(Z @ factors.solve(np.asarray(forces.T @ motion)))
    # Rounding of C = beta K is about 1e-16 of the terms of the sum
    along = np.asarray(Z.T @ (C @ motion))
    other = np.abs(along) > 1e-9 * (abs(Z).T @ (abs(C) @ np.abs(motion)))
    if other.any():
        raise SlipmodeError(
            f"damping: DOF {dof[other][0]} has no mass, and must have no damping but alpha M + "
            "beta K; give it mass, or use rom.Rayleigh"
        )


def _set(structure: Structure, **fields: Any) -> None:
    """Set fields of a frozen structure."""
    for name, value in fields.items():
        object.__setattr__(structure, name, value)


def _read_only(matrix: Matrix) -> Floats:
    array = as_dense(matrix)
    array.setflags(write=False)
    return array
