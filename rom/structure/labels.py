"""Node and direction of each DOF of a structure, as the program that made it numbers them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.arrays import in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


@frozen
class Labels:
    """Name the node and the direction of each DOF.

    Parameters
    ----------
    node : (n,) array of int
        Node number of each DOF.
    direction : (n,) array of int
        Direction of each DOF: 1, 2, 3 for displacements along x, y, z; 4, 5, 6 for rotations about
        x, y, z. Other numbers are allowed and have no meaning for slipmode.

    Raises
    ------
    SlipmodeError
        If the arrays are not integers of one length, or two DOFs have one node and direction.
    """

    node: NDArray[np.int64]
    direction: NDArray[np.int64]

    def __post_init__(self) -> None:
        for name, given in (("node", self.node), ("direction", self.direction)):
            numbers = _integers(given)
            if numbers is None:
                allowed = (
                    "1 to 6 for x, y, z, rx, ry, rz" if name == "direction" else "one per DOF"
                )
                raise SlipmodeError(
                    f"labels.{name}: must be integers, {allowed}, got {in_one_line(given)}"
                )
            object.__setattr__(self, name, numbers)
        if self.node.size != self.direction.size:
            sizes = f"{self.node.size} and {self.direction.size}"
            raise SlipmodeError(f"labels: node and direction must be equally long, got {sizes}")
        if len(self._index) < self.node.size:
            pairs, count = np.unique(self.table, axis=0, return_counts=True)
            node, direction = pairs[np.argmax(count)]
            raise SlipmodeError(f"labels: node {node} has direction {_name(direction)} twice")

    @property
    def table(self) -> NDArray[np.int64]:
        """Node and direction of each DOF, (n, 2) ndarray of int."""
        return np.stack((self.node, self.direction), axis=1)

    @cached_property
    def _index(self) -> dict[tuple[int, int], int]:
        return {(int(node), int(k)): dof for dof, (node, k) in enumerate(self.table)}

    def dof(self, node: int, direction: str) -> int:
        """Return the index of the DOF at a node in a direction.

        Parameters
        ----------
        node : int
            Node number.
        direction : {"x", "y", "z", "rx", "ry", "rz"}
            Displacement along an axis, or rotation about an axis.

        Returns
        -------
        int
            Index of the DOF, 0 to n - 1.

        Raises
        ------
        SlipmodeError
            If the direction is not allowed, the node is not in the structure, or the node has no
            DOF in this direction.
        """
        if direction not in DIRECTIONS:
            raise SlipmodeError(f"direction: must be {', '.join(DIRECTIONS)}, got {direction!r}")
        dof = self._index.get((int(node), DIRECTIONS.index(direction) + 1))
        if dof is not None:
            return dof
        found = [_name(int(k)) for k in self.direction[self.node == node]]
        if found:
            raise SlipmodeError(
                f"node {node}: has no free direction {direction}, allowed: {', '.join(found)}"
            )
        raise SlipmodeError(
            f"node {node}: is not in the structure, whose nodes are {self.node.min()} to "
            f"{self.node.max()}"
        )

    def places(self, others: Labels) -> NDArray[np.int64]:
        """Return the index of each DOF of other labels in these labels.

        Parameters
        ----------
        others : Labels
            Labels of (m,) DOFs.

        Returns
        -------
        (m,) ndarray of int
            Index of the DOF with equal node and direction, or -1 if there is none.
        """
        return np.array(
            [self._index.get((int(node), int(k)), -1) for node, k in others.table], dtype=np.int64
        )

    def dofs(self, nodes: Sequence[int] | NDArray[np.integer]) -> NDArray[np.int64]:
        """Return the indices of all DOFs of nodes.

        Parameters
        ----------
        nodes : sequence of int
            Node numbers.

        Returns
        -------
        (nodes, 3) or (nodes, 6) ndarray of int
            DOFs in the directions x, y, z, and rx, ry, rz if the structure has rotations. The
            index is -1 where a node is fixed or not in the structure.
        """
        count = 6 if np.any((self.direction > 3) & (self.direction <= 6)) else 3
        return np.array(
            [[self._index.get((int(n), k + 1), -1) for k in range(count)] for n in nodes],
            dtype=np.int64,
        )

    def directions(self, contacts: Sequence[Sequence[Any]]) -> Any:
        """Return the contact directions W of contacts that are named by nodes.

        Parameters
        ----------
        contacts : sequence of tuple
            (node, direction) for the displacement of a node, or (node, other node, direction) for
            the displacement of a node relative to the other node.

        Returns
        -------
        (n, N_c) sparse array
            W [-], with the entry +1 at the node and -1 at the other node.

        Raises
        ------
        SlipmodeError
            If a tuple has another length, or its node or direction is not in the structure.
        """
        entries, rows, columns = [], [], []
        for column, contact in enumerate(contacts):
            if len(contact) not in (2, 3):
                raise SlipmodeError(
                    "contact: must be (node, direction) or (node, other node, direction), got "
                    f"{tuple(contact)}"
                )
            *nodes, direction = contact
            for node, sign in zip(nodes, (1.0, -1.0), strict=False):
                rows.append(self.dof(int(node), str(direction)))
                columns.append(column)
                entries.append(sign)
        shape = (self.node.size, len(contacts))
        return scipy.sparse.csc_array((entries, (rows, columns)), shape=shape)


def _integers(given: Any) -> NDArray[np.int64] | None:
    """Return a list of integers as an array; None if it is something else."""
    try:
        array = np.asarray(given)
        with np.errstate(invalid="ignore"):  # NaN is no integer
            numbers = array.astype(np.int64)
    except (TypeError, ValueError, OverflowError):
        return None
    return numbers if array.ndim == 1 and np.array_equal(numbers, array) else None


def _name(direction: int) -> str:
    return DIRECTIONS[direction - 1] if 1 <= direction <= 6 else str(direction)
