"""Elastic and contact coordinates of a structure: x = E x_e + R x_c."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import (
    TOLERANCE,
    Matrix,
    MatrixLike,
    Sparse,
    as_csc,
    as_dense,
    as_matrix,
)

Indices = NDArray[np.intp]


@frozen
class Partition:
    """A structure in elastic coordinates x_e and contact displacements x_c = W^T x.

    x = E x_e + R x_c with W^T E = 0 and W^T R = I, so x_c = 0 is the bonded structure. With
    contact DOFs given by index, E and R are plain selections and the blocks are those of Eq. (3):
    M_ee = E^T M E (n_e, n_e), dense or CSC like the structure; M_ec = E^T M R (n_e, N_c) and
    M_cc = R^T M R (N_c, N_c), dense; C and K likewise. They are computed on first access.
    """

    E: Matrix  # (n, n_e), motion with contact displacements 0; sparse if the structure is
    R: Matrix  # (n, N_c), motion by unit contact displacements with x_e = 0; likewise
    elastic_dofs: Indices  # (n_e,), the DOFs that serve as x_e, ascending
    mass: Matrix  # (n, n), and so are damping and stiffness
    damping: Matrix
    stiffness: Matrix

    @classmethod
    def of(cls, mass: Matrix, damping: Matrix, stiffness: Matrix, directions: Matrix) -> Self:
        """Split the matrices of a structure along its contact directions W (n, N_c).

        R = S_p W_p^-T moves the pivot DOFs alone, so W^T R = I. E = S_e - R W^T S_e, with the unit
        motions S_e of the other DOFs, has W^T E = 0. Both are as sparse as W.
        """
        W, n_dofs = as_csc(directions), mass.shape[0]
        pivots = _pivot_dofs(W)
        elastic_dofs = np.setdiff1d(np.arange(n_dofs), pivots)
        S_e = _selection(elastic_dofs, n_dofs)
        R = _selection(pivots, n_dofs) @ as_csc(np.linalg.inv(W[pivots].toarray().T))
        E = S_e - R @ (W.T @ S_e)
        as_given = as_dense if isinstance(mass, np.ndarray) else as_csc
        return cls(as_given(E), as_given(R), elastic_dofs, mass, damping, stiffness)

    M_ee = cached_property(lambda self: self._elastic(self.mass))
    C_ee = cached_property(lambda self: self._elastic(self.damping))
    K_ee = cached_property(lambda self: self._elastic(self.stiffness))
    M_ec = cached_property(lambda self: as_dense(self.E.T @ (self.mass @ self.R)))
    C_ec = cached_property(lambda self: as_dense(self.E.T @ (self.damping @ self.R)))
    K_ec = cached_property(lambda self: as_dense(self.E.T @ (self.stiffness @ self.R)))
    M_cc = cached_property(lambda self: as_dense(self.R.T @ (self.mass @ self.R)))
    C_cc = cached_property(lambda self: as_dense(self.R.T @ (self.damping @ self.R)))
    K_cc = cached_property(lambda self: as_dense(self.R.T @ (self.stiffness @ self.R)))

    def _elastic(self, matrix: Matrix) -> Matrix:
        """Return E^T matrix E."""
        block: Any = self.E.T @ (matrix @ self.E)
        return block if isinstance(block, np.ndarray) else as_csc(block)


def contact_directions(contact: MatrixLike, n_dofs: int) -> Sparse:
    """Return contact directions W (n, N_c) from DOF indices or from a matrix, checked.

    1 <= N_c <= n; indices are distinct, W is finite, and no two of its columns are parallel.
    """
    given: Any = contact if scipy.sparse.issparse(contact) else np.asarray(contact)
    if given.ndim == 1:
        _check_dofs(given, n_dofs)
        W = _selection(given.astype(np.intp), n_dofs)
    else:
        W = as_csc(as_matrix("contact", given))
    rows, n_contacts = W.shape
    if rows != n_dofs:
        raise SlipmodeError(f"contact: W must have {n_dofs} rows, one per DOF, got {rows}")
    if not 1 <= n_contacts <= n_dofs:
        raise SlipmodeError(
            f"contact: must have 1 to {n_dofs} contacts, at most one per DOF, got {n_contacts}"
        )
    lengths = np.sqrt(W.power(2).sum(axis=0))
    if not lengths.all():
        raise SlipmodeError("contact: every direction (column of W) must have a nonzero entry")
    unit = W / lengths
    cosine = scipy.sparse.triu(abs(unit.T @ unit), 1).tocoo()
    same = np.flatnonzero(cosine.data > 1.0 - TOLERANCE)
    if same.size:
        i, j = (int(each[same[0]]) for each in cosine.coords)
        raise SlipmodeError(
            f"contact: directions (columns of W) must be linearly independent; {i} and {j} are "
            "the same"
        )
    return W


def _check_dofs(contact: NDArray[Any], n_dofs: int) -> None:
    if contact.size == 0:
        raise SlipmodeError("contact: must name at least one DOF")
    if contact.dtype.kind not in "iu":
        raise SlipmodeError(f"contact: DOF indices must be integers, got dtype {contact.dtype}")
    outside = contact[(contact < 0) | (contact >= n_dofs)]
    if outside.size:
        raise SlipmodeError(
            f"contact: DOF {outside[0]} is out of range, allowed: 0 to {n_dofs - 1}"
        )
    if np.unique(contact).size < contact.size:
        raise SlipmodeError("contact: DOF indices must be distinct")


def _selection(dofs: Indices, n_dofs: int) -> Sparse:
    """Return the columns of the identity at `dofs`."""
    columns = np.arange(dofs.size)
    return scipy.sparse.csc_array((np.ones(dofs.size), (dofs, columns)), shape=(n_dofs, dofs.size))


def _pivot_dofs(W: Sparse) -> Indices:
    """Return one DOF per contact, ascending, so that W restricted to them is well conditioned."""
    lengths = np.sqrt(W.power(2).sum(axis=0))
    touched = np.unique(W.indices)
    unit_rows = W[touched].toarray().T / lengths[:, np.newaxis]
    triangle, order = scipy.linalg.qr(unit_rows, mode="r", pivoting=True)
    pivots = np.abs(np.diag(triangle))
    if pivots.size < W.shape[1] or pivots[-1] <= TOLERANCE * pivots[0]:
        raise SlipmodeError(
            "contact: directions (columns of W) of rigid contacts must be linearly independent; "
            "for dependent ones, as in a closed ring, use elastic contacts (rom.Jenkins)"
        )
    return np.sort(touched[order[: W.shape[1]]]).astype(np.intp)
