"""A structure with dry-friction contacts: its matrices, validated once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.files import as_path
from slipmode.rom.representable import SMALLEST
from slipmode.rom.structure.damping import Rayleigh
from slipmode.rom.structure.external import read_external
from slipmode.rom.structure.files import read_matrices, write_npz
from slipmode.rom.structure.formats import READERS
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.matrices import Matrix, MatrixLike, as_csc, as_dense, as_symmetric
from slipmode.rom.structure.partition import Partition, contact_directions
from slipmode.rom.structure.solvers.mass import is_positive_mass, is_positive_semidefinite


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Structure:
    """Matrices and contact directions of a structure with dry friction, Eq. (1).

    The equation of motion is M x'' + C x' + K x + W g = f, with the contact forces g (N_c,) that
    a contact law gives for the contact motion x_c = W^T x. The law is not part of the structure.

    Parameters
    ----------
    mass : (n, n) array or sparse matrix
        M [kg], symmetric and positive definite.
    stiffness : (n, n) array or sparse matrix
        K [N/m] without contacts, symmetric. Rigid-body modes are allowed here. `rom.reduce`
        refuses those that remain with bonded contacts (Tanh, Coulomb); with the springs of
        elastic contacts they may remain, but cannot be retained.
    damping : float, Rayleigh, or (n, n) array or sparse matrix, default 0.0
        beta [s] of C = beta K, `Rayleigh` for C = alpha M + beta K, or C itself [N s/m],
        symmetric and positive semidefinite.
    contact : sequence of int, or (n, N_c) array or sparse matrix
        Indices of the contact DOFs, or the directions W [-], with 1 <= N_c <= n columns, no two
        of them parallel; of rigid contacts (Tanh, Coulomb) linearly independent. A column with +1
        and -1 is the relative displacement of two nodes.
    labels : Labels, optional
        Node and direction of each DOF.

    Attributes
    ----------
    mass, stiffness, damping : (n, n) matrix
        M, K and C. Read-only ndarrays, or CSC arrays if mass or stiffness was given sparse.
    beta : float or None
        The factor of C = beta K [s]. None for any other damping.
    directions : (n, N_c) matrix
        W, dense or CSC like the other matrices.
    labels : Labels or None
        Node and direction of each DOF.
    """

    mass: Matrix
    stiffness: Matrix
    beta: float | None
    directions: Matrix
    labels: Labels | None
    _damping: Matrix | Rayleigh

    def __init__(
        self,
        mass: MatrixLike,
        stiffness: MatrixLike,
        damping: float | Rayleigh | MatrixLike = 0.0,
        *,
        contact: MatrixLike,
        labels: Labels | None = None,
    ) -> None:
        M = as_symmetric("mass", mass)
        if not is_positive_mass(M):
            raise SlipmodeError("mass: must be positive definite (every DOF needs some mass)")
        if M.diagonal().min() < SMALLEST:
            raise SlipmodeError(f"mass: every DOF needs at least {SMALLEST:g}; use other units")
        K = as_symmetric("stiffness", stiffness, M.shape[0])
        C = checked_damping(damping, M.shape[0])
        if labels is not None and labels.node.size != M.shape[0]:
            raise SlipmodeError(f"labels: must be {M.shape[0]}, got {labels.node.size}")
        W = contact_directions(contact, M.shape[0])
        is_dense = isinstance(M, np.ndarray) and isinstance(K, np.ndarray)
        store: Callable[[Matrix], Matrix] = _read_only if is_dense else as_csc
        _set(
            self,
            mass=store(M),
            stiffness=store(K),
            beta=C.beta if isinstance(C, Rayleigh) and C.alpha == 0.0 else None,
            directions=store(W),
            labels=labels,
            _damping=C if isinstance(C, Rayleigh) else store(C),
        )

    def __repr__(self) -> str:
        storage = "dense" if isinstance(self.mass, np.ndarray) else "sparse"
        return f"Structure({self.n_dofs} DOFs, {self.n_contacts} contacts, {storage})"

    @property
    def n_dofs(self) -> int:
        """The number n of degrees of freedom."""
        return int(self.mass.shape[0])

    @property
    def n_contacts(self) -> int:
        """The number N_c of contact directions."""
        return int(self.directions.shape[1])

    def with_forces(self, stiffness: Floats, damping: Floats) -> Structure:
        """Return the structure, dense, under external linear forces -K x - C x'.

        K and C are symmetric; unlike those of a structure they may feed energy in.
        """
        other = copy(self)
        _set(
            other,
            mass=_read_only(self.mass),
            stiffness=_read_only(as_dense(self.stiffness) + stiffness),
            _damping=_read_only(as_dense(self.damping) + damping),
            directions=_read_only(self.directions),
            beta=None,
        )
        return other

    @property
    def damping(self) -> Matrix:
        """C (n, n) [N s/m]; computed at every access if it is alpha M + beta K."""
        given = self._damping
        if not isinstance(given, Rayleigh):
            return given
        C: Any = self.stiffness * given.beta
        if given.alpha:
            C = C + self.mass * given.alpha
        return _read_only(C) if isinstance(C, np.ndarray) else C

    def partition(self) -> Partition:
        """Split the matrices into elastic and contact coordinates, Eq. (3)."""
        return Partition.of(self.mass, self.damping, self.stiffness, self.directions)

    def save(self, path: str | PathLike[str]) -> None:
        """Write a .npz file that `load_structure` reads back to the last bit."""
        matrices: dict[str, Any] = {
            "mass": self.mass,
            "stiffness": self.stiffness,
            "damping": self.damping if self.beta is None else self.beta,
            "contact": self.directions,
        }
        if self.labels is not None:
            matrices["labels"] = self.labels.table
        write_npz(Path(path), matrices)


def load_structure(
    path: str | PathLike[str],
    damping: float | Rayleigh | MatrixLike | None = None,
    *,
    mass: str | PathLike[str] | None = None,
    contact: MatrixLike | Sequence[Sequence[Any]] | None = None,
) -> Structure:
    """Read a structure from a file of slipmode or of another program.

    Parameters
    ----------
    path : path
        - A .npz file with arrays mass, stiffness, contact (DOF indices or W) and optionally
          damping (C, or the number beta); a sparse matrix is stored as mass_data,
          mass_indices, mass_indptr and mass_shape (CSR).
        - A folder with mass.mtx, stiffness.mtx, optionally damping.mtx (Matrix Market), and
          contact.mtx (W) or contact.txt (indices).
        - Of the stiffness: .mtx of Matrix Market or of Abaqus (*MATRIX GENERATE), .sti of
          CalculiX, Harwell-Boeing (.hb, .rsa, .rua, .matrix) of Ansys and others.
        - Of all matrices: .mat of MATLAB (mass or M, stiffness or K, ...); .op4, .pch of Nastran
          (KGG, MGG, ...; with `pip install 'slipmode[nastran]'`); .full of Ansys (with
          `slipmode[ansys]`).
    damping : float, Rayleigh or (n, n) matrix, optional
        Replaces the stored damping; by default the stored damping or none.
    mass : path, optional
        File of the mass, if it is a separate one. The file of the same job of Abaqus
        (JOB_MASS1.mtx of JOB_STIF1.mtx) or CalculiX (.mas) is found by itself.
    contact : as of Structure, or sequence of (node, direction) or (node, node, direction)
        Replaces the stored contacts. Nodes have the numbers of the other program, directions are
        "x", "y", "z", "rx", "ry", "rz"; two nodes stand for their relative motion.
    """
    file = as_path("path", path)
    if file.is_dir() or file.suffix not in READERS:
        matrices = read_matrices(file)
    else:
        matrices = read_external(file, None if mass is None else Path(mass))
    if damping is not None:
        matrices["damping"] = damping
    with naming(path):
        if contact is not None:
            matrices["contact"] = _labelled(contact, matrices.get("labels"))
        if "contact" not in matrices:
            raise SlipmodeError(
                'contact: is missing; give contact=, as DOF indices, W or [(node, "x"), ...]'
            )
        return Structure(**matrices)


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
    """Return two modal masses on a common friction contact: Eq. (26), values of Table 1.

    DOFs are x_e1, x_e2, x_c1, x_c2; the last two are the contact. Bonded natural
    frequencies are sqrt(k1/m1) = 1 and sqrt(k2/m2) = 1.7 rad/s.

    Parameters
    ----------
    beta : float
        Stiffness-proportional damping [s], C = beta K.
    m1, m2, contact_mass : float
        Modal masses, and mass of each contact DOF [kg], positive.
    k1, k2 : float
        Stiffness between each mass and its contact DOF [N/m].
    k_c1, k_c2, k_p : float
        Stiffness of the contact DOFs to the ground, and off-diagonal entry that couples them, with
        the sign of Eq. (26) [N/m].
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


def checked_damping(damping: float | Rayleigh | MatrixLike, size: int) -> Matrix | Rayleigh:
    """Return C, or how it follows from mass and stiffness."""
    if isinstance(damping, Rayleigh):
        return damping
    if isinstance(damping, float | int | np.floating):
        return Rayleigh(0.0, float(damping))
    C = as_symmetric("damping", damping, size)
    if not is_positive_semidefinite(C, "damping"):
        raise SlipmodeError("damping: must be positive semidefinite (it must not add energy)")
    return C


def _set(structure: Structure, **fields: Any) -> None:
    """Set fields of a frozen structure."""
    for name, value in fields.items():
        object.__setattr__(structure, name, value)


def _read_only(matrix: Matrix) -> Floats:
    array = as_dense(matrix)
    array.setflags(write=False)
    return array
