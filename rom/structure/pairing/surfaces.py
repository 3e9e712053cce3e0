"""Surfaces of a mesh as they are given, by nodes or by facets, checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.pairing.facets import Facets, Indices


@dataclass(frozen=True)
class Surface:
    """The nodes of a surface, and what its facets say where it has some.

    Attributes
    ----------
    name : str
        Of the argument that it came as.
    nodes : (nodes,) ndarray of int
        Each once: as they were listed, or those of the facets in ascending order.
    position : (nodes, 3) ndarray
        [m]
    facets : Facets or None
    """

    name: str
    nodes: Indices
    position: Floats
    facets: Facets | None

    __repr__ = short_repr

    def areas_and_normals(self) -> tuple[Floats, Floats]:
        """What each node has of the area, (nodes,) [m^2], and unit normals, (nodes, 3)."""
        assert self.facets is not None
        area, vector = np.zeros(len(self.nodes)), np.zeros((len(self.nodes), 3))
        place = np.searchsorted(self.nodes, self.facets.nodes)
        for total, part in zip((area, vector), self.facets.integrals(), strict=True):
            np.add.at(total, place, part)
        length = np.linalg.norm(vector, axis=1)
        if np.any(length <= 0.1 * area):
            node = self.nodes[np.argmin(length / area)]
            raise SlipmodeError(
                f"{self.name}: facets around node {node} face opposite ways; a surface must not "
                "fold back on itself"
            )
        return area, vector / length[:, np.newaxis]


def as_surface(name: str, given: ArrayLike, coordinates: Floats, normal: Floats | None) -> Surface:
    """The surface of nodes (nodes,) or facets (facets, 3 or 4).

    Facets are turned so that their outer side is that of `normal`, (3,), where there is one.
    """
    numbers = _numbers(name, given)
    unknown = numbers[(numbers < 0) | (numbers >= len(coordinates))]
    if unknown.size:
        raise SlipmodeError(
            f"{name}: node {unknown[0]} is unknown; coordinates has nodes 0 to "
            f"{len(coordinates) - 1}"
        )
    if numbers.ndim == 1:
        _no_duplicates(name, numbers)
        return Surface(name, numbers, coordinates[numbers], None)
    if numbers.shape[1] == 3:
        numbers = numbers[:, [0, 1, 2, 2]]
    _no_duplicate_facets(name, numbers)
    facets = Facets(numbers, coordinates[numbers])
    if normal is not None:
        facets = facets.turned(name, normal)
    facets.check(name)
    nodes = np.unique(numbers)
    return Surface(name, nodes, coordinates[nodes], facets)


def _numbers(name: str, given: ArrayLike) -> Indices:
    try:
        numbers: Any = np.asarray(given)
    except ValueError:
        numbers = np.empty((0, 0, 0))
    listed = numbers.ndim == 1 or (numbers.ndim == 2 and numbers.shape[1] in (3, 4))
    if not listed:
        raise SlipmodeError(
            f"{name}: must be a list of nodes, or facets (facets, 3 or 4); a triangle among "
            "quadrilaterals has its last node twice, facets with midside nodes are split into "
            "such ones"
        )
    if numbers.size == 0:
        raise SlipmodeError(f"{name}: must have at least one node")
    if numbers.dtype.kind not in "iu":
        raise SlipmodeError(f"{name}: nodes must be integers, got dtype {numbers.dtype}")
    return np.asarray(numbers, dtype=np.intp)


def _no_duplicates(name: str, nodes: Indices) -> None:
    found, count = np.unique(nodes, return_counts=True)
    if np.any(count > 1):
        raise SlipmodeError(f"{name}: node {found[np.argmax(count > 1)]} is there twice")


def _no_duplicate_facets(name: str, facets: Indices) -> None:
    corners = np.sort(facets, axis=1)
    again = corners[:, 1:] == corners[:, :-1]
    again &= ~((facets[:, 2] == facets[:, 3])[:, None] & (corners[:, 1:] == facets[:, [3]]))
    again |= (corners[:, [0, 0, 1]] == corners[:, [2, 3, 3]]).any(axis=1)[:, None]
    if again.any():
        facet = int(np.argmax(again.any(axis=1)))
        raise SlipmodeError(
            f"{name}: facet {facet} has a node twice; only a triangle among quadrilaterals has, "
            "its last one"
        )
    _, first, where, count = np.unique(
        corners, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    if np.any(count > 1):
        last = int(np.flatnonzero(count[where] > 1)[-1])
        raise SlipmodeError(f"{name}: facets {first[where[last]]} and {last} have the same nodes")
