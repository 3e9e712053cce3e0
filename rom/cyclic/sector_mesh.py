"""Sectors of a mesh: nodes on either side that meet, and directions that turn with the sector."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import SlipmodeError, Structure
from slipmode.rom.common import Floats, as_floats, in_one_line
from slipmode.rom.cyclic.structure import CyclicStructure, checked_integer, distinct
from slipmode.rom.structure import MatrixLike, as_csc, as_matrix

_FITS = 1e-5  # distance of nodes that meet, relative to the sector's extent: rounded exports


class SectorMesh:
    """Hold the nodes of a sector of a disk, in Cartesian coordinates of the disk.

    The next sector is this sector turned by 2 pi / N about the axis, counter-clockwise as seen
    from the tip of the axis.

    Parameters
    ----------
    coordinates : (nodes, 3) array_like
        Positions [m]; the axis goes through the origin.
    dofs : (nodes, 3) or (nodes, 6) array_like of int
        DOFs of the x, y, z displacement of each node, and of its rotations; -1 where it is fixed.
        `Labels.dofs` of `Structure.labels` returns them for a finite element model.
    left, right : (k,) array_like of int
        Nodes on the two sides, as rows of `coordinates`, in any order. The nodes `right` coincide
        with the nodes `left` of the next sector.
    axis : {"x", "y", "z"}, default "z"
        Axis of rotation.

    Raises
    ------
    SlipmodeError
        If an argument has a wrong shape or value.
    """

    def __init__(
        self,
        coordinates: ArrayLike,
        dofs: ArrayLike,
        left: ArrayLike,
        right: ArrayLike,
        axis: str = "z",
    ) -> None:
        points, table = as_floats("coordinates", coordinates), np.asarray(dofs)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise SlipmodeError(
                f"coordinates: must be finite, of shape (nodes, 3), got {points.shape}"
            )
        if table.dtype.kind not in "iu" or table.shape not in ((len(points), 3), (len(points), 6)):
            raise SlipmodeError(
                f"dofs: must be integers of shape ({len(points)}, 3) or (.., 6), got "
                f"{table.dtype} {table.shape}"
            )
        if axis not in ("x", "y", "z"):
            raise SlipmodeError(f"axis: must be one of x, y, z, got {in_one_line(axis)}")
        self.coordinates, self.dofs, self.axis = points, table.astype(np.intp), axis
        self.left, self.right = (
            distinct(name, nodes, len(points), "nodes")
            for name, nodes in (("left", left), ("right", right))
        )
        if self.left.size != self.right.size or not self.left.size:
            raise SlipmodeError(
                f"left, right: must be as many nodes on either side, at least one, got "
                f"{self.left.size} and {self.right.size}"
            )

    def cyclic(
        self, structure: Structure, sectors: int, next_contact: MatrixLike | None = None
    ) -> CyclicStructure:
        """Return the cyclic structure of a sector.

        Parameters
        ----------
        structure : Structure
            One sector with the DOFs on both of its sides, in x, y, z of the disk, and with the
            contact directions of one sector.
        sectors : int
            Number of sectors N.
        next_contact : (n, N_c) array or sparse matrix, optional
            Directions of the contacts on the next sector [-], in x, y, z of the disk. See
            `with_next`. Default: no contacts between neighbouring sectors.

        Returns
        -------
        CyclicStructure
            Disk in rotated coordinates of each sector.

        Raises
        ------
        SlipmodeError
            If the sides do not coincide after a rotation by 2 pi / N.
        """
        size = structure.n_dofs
        if self.dofs.max() >= size or np.unique(self.dofs[self.dofs >= 0]).size != size:
            raise SlipmodeError(
                f"dofs: must have each of the {size} DOFs of the structure at one node"
            )
        if structure.loss is not None:
            raise SlipmodeError(
                "structure: must have no structural damping; use rom.Rayleigh.from_loss_factor"
            )
        R = self._rotation(sectors)
        left, right = self._pairs(R)
        # Displacements on the right in the directions of the next sector
        at_right = self._turned(R, right, size)
        M, C, K = (
            _symmetric(at_right.T @ as_csc(each) @ at_right)
            for each in (structure.mass, structure.damping, structure.stiffness)
        )
        other: Any = None
        if next_contact is not None:
            everywhere = self._turned(R, np.arange(len(self.dofs)), size)
            other = at_right.T @ everywhere.T @ as_csc(as_matrix("next_contact", next_contact))
        both = self.dofs[left], self.dofs[right]
        return CyclicStructure(
            M,
            K,
            sectors,
            structure.beta if structure.beta is not None else C,
            contact=at_right.T @ as_csc(structure.directions),
            next_contact=other,
            left=both[0][both[0] >= 0].tolist(),
            right=both[1][both[1] >= 0].tolist(),
        )

    def with_next(self, sectors: int) -> tuple[Floats, NDArray[np.intp]]:
        """Return coordinates and DOFs of this sector and the next sector, for `rom.contact_pairs`.

        The nodes of the next sector follow the nodes of this sector. Their DOFs are n to 2 n - 1.
        In the contact directions W (2 n, N_c) the first n rows are the directions of this sector.
        The last n rows are `next_contact` of `cyclic`.

        Parameters
        ----------
        sectors : int
            Number of sectors N.

        Returns
        -------
        coordinates : (2 nodes, 3) ndarray
            Positions [m].
        dofs : (2 nodes, 3) or (2 nodes, 6) ndarray of int
            DOFs of each node; -1 where it is fixed.
        """
        turned = self.coordinates @ self._rotation(sectors).T
        size = int(self.dofs.max()) + 1
        following = np.where(self.dofs < 0, -1, self.dofs + size)
        return np.vstack((self.coordinates, turned)), np.vstack((self.dofs, following))

    def _rotation(self, sectors: int) -> Floats:
        """Return the matrix of the rotation from a sector to the next."""
        angle = 2.0 * np.pi / checked_integer("sectors", sectors, ">= 3", 3)
        return np.asarray(
            scipy.spatial.transform.Rotation.from_euler(self.axis, angle).as_matrix()
        )

    def _pairs(self, R: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return nodes on the left and, of the same order, on the right; refuse others."""
        turned = self.coordinates[self.left] @ R.T
        found = scipy.spatial.KDTree(self.coordinates[self.right]).query(turned)
        distance, place = (np.asarray(each) for each in found)
        extent = float(np.ptp(self.coordinates, axis=0).max())
        worst = int(np.argmax(distance))
        if distance[worst] > _FITS * extent or np.unique(place).size != place.size:
            raise SlipmodeError(
                f"left, right: node {self.left[worst]} of left, turned by one sector about "
                f"{self.axis}, is {distance[worst]:.3g} m away from the nearest node of right; "
                "check sectors, axis, and whether left and right are exchanged"
            )
        right = self.right[place]
        free = self.dofs.reshape(len(self.dofs), -1, 3) >= 0
        across = np.delete(free[right], "xyz".index(self.axis), axis=2)
        differs = (free[self.left] != free[right]).any(axis=(1, 2))
        differs |= (across[..., 0] != across[..., 1]).any(axis=1)
        if differs.any():
            raise SlipmodeError(
                f"left, right: nodes {self.left[np.argmax(differs)]} and "
                f"{right[np.argmax(differs)]} meet, but have different free DOFs across "
                f"{self.axis}; fix the same directions of both"
            )
        return self.left, right

    def _turned(self, R: Floats, nodes: NDArray[np.intp], size: int) -> Any:
        """Return the displacements (n, n), turned at some nodes, where they are not held."""
        triples = self.dofs[nodes].reshape(-1, 3)
        rows, columns = np.repeat(triples, 3, axis=1).ravel(), np.tile(triples, 3).ravel()
        values = np.tile((R - np.eye(3)).ravel(), len(triples))
        kept = (rows >= 0) & (columns >= 0)
        turn = scipy.sparse.coo_array((values[kept], (rows[kept], columns[kept])), (size, size))
        return scipy.sparse.csc_array(scipy.sparse.eye_array(size) + turn)


def _symmetric(matrix: Any) -> Any:
    """Return a matrix without the asymmetry of rounding."""
    return 0.5 * (matrix + matrix.T)
