"""Surfaces of a mesh: nodes, or facets with linear shape functions, as users give them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Facets:
    """Triangles and quadrilaterals, corners counter-clockwise as seen from outside the body."""

    nodes: Indices  # (facets, 4); the last node of a triangle is there twice
    corners: Floats  # (facets, 4, 3), positions [m]

    __repr__ = short_repr

    @property
    def triangular(self) -> Flags:
        """Which facets are triangles, (facets,)."""
        return np.asarray(self.nodes[:, 2] == self.nodes[:, 3])

    def integrals(self) -> tuple[Floats, Floats]:
        """Return integrals of the shape functions and of them times the unit normal [m^2].

        Shapes (facets, 4) and (facets, 4, 3). Four Gauss points; a triangle needs one.
        """
        area, vector = np.zeros(self.nodes.shape), np.zeros(self.corners.shape)
        triangular = self.triangular
        weight = np.where(triangular, 0.125, 1.0)  # a triangle: four times a quarter of area / 2
        for signs in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            gauss = np.array(signs) / np.sqrt(3.0)
            at = np.where(triangular[:, np.newaxis], 1.0 / 3.0, gauss)
            N, slopes = shape_functions(triangular, at)
            tangents = slopes @ self.corners
            normal = np.cross(tangents[:, 0], tangents[:, 1]) * weight[:, np.newaxis]
            area += N * np.linalg.norm(normal, axis=1)[:, np.newaxis]
            vector += N[:, :, np.newaxis] * normal[:, np.newaxis]
        return area, vector

    def size(self) -> Floats:
        """Return the largest distance of a corner from the mean of the corners, (facets,) [m]."""
        offset = self.corners - self.corners.mean(axis=1, keepdims=True)
        return np.asarray(np.linalg.norm(offset, axis=2).max(axis=1))

    def turned(self, name: str, direction: Floats) -> Facets:
        """Return the facets with their outer side towards a direction (3,)."""
        vector: Floats = self.integrals()[1].sum(axis=1)
        cosine = vector / np.linalg.norm(vector, axis=1)[:, np.newaxis] @ direction
        if np.any(np.abs(cosine) < 0.1):
            facet = int(np.argmin(np.abs(cosine)))
            raise SlipmodeError(
                f"normal: lies in the plane of facet {facet} of {name}, so it does not tell the "
                "outer side of the facet; order the nodes of facets counter-clockwise as seen "
                "from outside, and leave normal out"
            )
        reverse = np.where(self.triangular[:, np.newaxis], [0, 2, 1, 1], [0, 3, 2, 1])
        order = np.where((cosine < 0.0)[:, np.newaxis], reverse, np.arange(4))
        rows = np.arange(len(order))[:, np.newaxis]
        return Facets(self.nodes[rows, order], self.corners[rows, order])

    def check_nodes(self, name: str) -> None:
        """Refuse a facet of the surface `name` that has a node twice or is listed twice."""
        corners = np.sort(self.nodes, axis=1)
        again = corners[:, 1:] == corners[:, :-1]
        again &= ~(self.triangular[:, None] & (corners[:, 1:] == self.nodes[:, [3]]))
        again |= (corners[:, [0, 0, 1]] == corners[:, [2, 3, 3]]).any(axis=1)[:, None]
        if again.any():
            facet = int(np.argmax(again.any(axis=1)))
            raise SlipmodeError(
                f"{name}: facet {facet} has a node twice; only a triangle among quadrilaterals "
                "may have its last node twice"
            )
        if pair := _first_repeated(corners):
            raise SlipmodeError(f"{name}: facets {pair[0]} and {pair[1]} have the same nodes")

    def check_sides(self, name: str) -> None:
        """Refuse a facet of the surface `name` without area, or turned against its neighbour."""
        flat = self.integrals()[0].sum(axis=1) <= 1e-12 * self.size() ** 2
        if flat.any():
            raise SlipmodeError(f"{name}: facet {np.argmax(flat)} has no area")
        facet, corner = np.nonzero(self.nodes != np.roll(self.nodes, -1, axis=1))
        edges = np.stack((self.nodes[facet, corner], self.nodes[facet, (corner + 1) % 4]), axis=1)
        if pair := _first_repeated(edges):
            raise SlipmodeError(
                f"{name}: facets {facet[pair[0]]} and {facet[pair[1]]} have opposite normals; "
                "order the nodes of facets counter-clockwise as seen from outside the body, or "
                "give normal, which orients them"
            )


@dataclass(frozen=True)
class Surface:
    """The nodes of a surface, each once, and its facets if it has some."""

    name: str  # argument that it was given as
    nodes: Indices  # (nodes,), as listed, or the nodes of the facets in ascending order
    position: Floats  # (nodes, 3) [m]
    facets: Facets | None

    __repr__ = short_repr

    def areas_and_normals(self) -> tuple[Floats, Floats]:
        """Return the area of each node (nodes,) [m^2] and unit normals (nodes, 3), of facets."""
        assert self.facets is not None
        area, vector = np.zeros(len(self.nodes)), np.zeros((len(self.nodes), 3))
        place = np.searchsorted(self.nodes, self.facets.nodes)
        for total, part in zip((area, vector), self.facets.integrals(), strict=True):
            np.add.at(total, place, part)
        length = np.linalg.norm(vector, axis=1)
        if np.any(length <= 0.1 * area):
            node = self.nodes[np.argmin(length / area)]
            raise SlipmodeError(
                f"{self.name}: facets around node {node} have opposite normals; a surface must "
                "not fold back on itself"
            )
        return area, vector / length[:, np.newaxis]


def as_surface(
    name: str, given: ArrayLike, coordinates: Floats, direction: Floats | None
) -> Surface:
    """Return the surface of nodes (nodes,) or facets (facets, 3 or 4), checked.

    The outer side of facets is turned towards `direction` (3,), if it is given.
    """
    numbers = _numbers(name, given)
    unknown = numbers[(numbers < 0) | (numbers >= len(coordinates))]
    if unknown.size:
        raise SlipmodeError(
            f"{name}: node {unknown[0]} is unknown; coordinates has nodes 0 to "
            f"{len(coordinates) - 1}"
        )
    if numbers.ndim == 1:
        found, count = np.unique(numbers, return_counts=True)
        if np.any(count > 1):
            raise SlipmodeError(
                f"{name}: node {found[np.argmax(count > 1)]} occurs twice; each must occur once"
            )
        return Surface(name, numbers, coordinates[numbers], None)
    if numbers.shape[1] == 3:
        numbers = numbers[:, [0, 1, 2, 2]]
    facets = Facets(numbers, coordinates[numbers])
    facets.check_nodes(name)
    if direction is not None:
        facets = facets.turned(name, direction)
    facets.check_sides(name)
    nodes = np.unique(numbers)
    return Surface(name, nodes, coordinates[nodes], facets)


def _numbers(name: str, given: ArrayLike) -> Indices:
    try:
        numbers: Any = np.asarray(given)
    except ValueError:
        numbers = np.empty((0, 0, 0))
    if not (numbers.ndim == 1 or (numbers.ndim == 2 and numbers.shape[1] in (3, 4))):
        raise SlipmodeError(
            f"{name}: must be a list of nodes, or facets of shape (facets, 3) or (facets, 4); "
            "repeat the last node of a triangle among quadrilaterals, and split facets with "
            "midside nodes"
        )
    if numbers.size == 0:
        raise SlipmodeError(f"{name}: must have at least one node")
    if numbers.dtype.kind not in "iu":
        raise SlipmodeError(f"{name}: nodes must be integers, got dtype {numbers.dtype}")
    return np.asarray(numbers, dtype=np.intp)


def _first_repeated(rows: Indices) -> tuple[int, int] | None:
    """Return the last row that is there before, and where it is first; None if all differ."""
    _, first, where, count = np.unique(
        rows, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    repeated = np.flatnonzero(count[where.ravel()] > 1)
    if not repeated.size:
        return None
    last = int(repeated[-1])
    return int(first[where.ravel()[last]]), last


def shape_functions(triangular: Flags, at: Floats) -> tuple[Floats, Floats]:
    """Return values (k, 4) and slopes (k, 2, 4) of shape functions at local coordinates (k, 2).

    Coordinates go from 0 to 1 in triangles (their sum too), from -1 to 1 in quadrilaterals.
    """
    a, b = at.T
    triangle = np.stack((1.0 - a - b, a, b, 0.0 * a), axis=-1)
    triangle_slopes = np.array([[-1.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0]])
    signs = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]])
    along, across = 1.0 + signs[0] * a[:, np.newaxis], 1.0 + signs[1] * b[:, np.newaxis]
    slopes = 0.25 * np.stack((signs[0] * across, signs[1] * along), axis=1)
    chosen = triangular[:, np.newaxis]
    return (
        np.where(chosen, triangle, 0.25 * along * across),
        np.where(chosen[:, np.newaxis], triangle_slopes, slopes),
    )
