"""Facets of a surface: triangles and quadrilaterals with linear shape functions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr

Indices = NDArray[np.intp]

_SIDEWAYS = 0.1  # cosine of the angle to the normal below which a facet has no clear side
_GAUSS = 1.0 / np.sqrt(3.0)
_FLAT = 1e-12  # area relative to the square of the size


@dataclass(frozen=True)
class Facets:
    """Facets with their corners counter-clockwise as seen from outside the body.

    Attributes
    ----------
    nodes : (facets, 4) ndarray of int
        The last node of a triangle is there twice.
    corners : (facets, 4, 3) ndarray
        [m]
    """

    nodes: Indices
    corners: Floats

    __repr__ = short_repr

    @property
    def triangular(self) -> Flags:
        """Which are triangles, (facets,)."""
        return np.asarray(self.nodes[:, 2] == self.nodes[:, 3])

    def integrals(self) -> tuple[Floats, Floats]:
        """Of each shape function: over the area, (facets, 4) [m^2], and that times the normal."""
        area, vector = np.zeros(self.nodes.shape), np.zeros(self.corners.shape)
        triangular = self.triangular
        weight = np.where(triangular, 1.0 / 8.0, 1.0)  # four times the one point of a triangle
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            at = np.where(triangular[:, np.newaxis], 1.0 / 3.0, _GAUSS * np.array([a, b]))
            N, slopes = shape_functions(triangular, at)
            normal = np.cross(*np.moveaxis(slopes @ self.corners, 1, 0)) * weight[:, np.newaxis]
            area += N * np.linalg.norm(normal, axis=1)[:, np.newaxis]
            vector += N[:, :, np.newaxis] * normal[:, np.newaxis]
        return area, vector

    def normals(self) -> Floats:
        """Mean unit normal of each, outwards, (facets, 3)."""
        vector: Floats = self.integrals()[1].sum(axis=1)
        return np.asarray(vector / np.linalg.norm(vector, axis=1)[:, np.newaxis])

    def size(self) -> Floats:
        """Largest distance of a corner from the mean of the corners, (facets,) [m]."""
        offset = self.corners - self.corners.mean(axis=1, keepdims=True)
        return np.asarray(np.linalg.norm(offset, axis=2).max(axis=1))

    def turned(self, name: str, normal: Floats) -> Facets:
        """With those turned over whose outer side is not that of the normal (3,)."""
        cosine = self.normals() @ normal
        if np.any(np.abs(cosine) < _SIDEWAYS):
            facet = int(np.argmin(np.abs(cosine)))
            raise SlipmodeError(
                f"normal: lies in facet {facet} of {name}, so that it cannot say which side of "
                "the facet faces the other body; order the nodes of facets counter-clockwise as "
                "seen from outside, and leave normal out"
            )
        over = cosine < 0.0
        order = np.where(
            self.triangular[:, np.newaxis], np.array([0, 2, 1, 1]), np.array([0, 3, 2, 1])
        )
        order[~over] = np.arange(4)
        rows = np.arange(len(order))[:, np.newaxis]
        return Facets(self.nodes[rows, order], self.corners[rows, order])

    def check(self, name: str) -> None:
        """Each has an area, and neighbours are on the same side.

        Raises
        ------
        SlipmodeError
            With the name of the surface in front.
        """
        flat = self.integrals()[0].sum(axis=1) <= _FLAT * self.size() ** 2
        if flat.any():
            raise SlipmodeError(f"{name}: facet {np.argmax(flat)} has no area")
        facet, corner = np.nonzero(self.nodes != np.roll(self.nodes, -1, axis=1))
        edges = np.stack((self.nodes[facet, corner], self.nodes[facet, (corner + 1) % 4]), axis=1)
        _, first, where, count = np.unique(
            edges, axis=0, return_index=True, return_inverse=True, return_counts=True
        )
        twice = np.flatnonzero(count[where] > 1)
        if twice.size:
            other = first[where[twice[-1]]]
            raise SlipmodeError(
                f"{name}: facets {facet[other]} and {facet[twice[-1]]} have opposite sides out; "
                "order the nodes of facets counter-clockwise as seen from outside the body, or "
                "give normal, which turns them"
            )


def shape_functions(triangular: Flags, at: Floats) -> tuple[Floats, Floats]:
    """Values (k, 4) and slopes (k, 2, 4) at local coordinates (k, 2).

    They go from 0 to 1 in triangles (their sum too), from -1 to 1 in quadrilaterals.
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


def overhang(triangular: Flags, at: Floats) -> Floats:
    """How far local coordinates (k, 2) are outside, as a part of the facet; 0 within."""
    a, b = at.T
    beyond = np.where(
        triangular,
        np.max((-a, -b, a + b - 1.0), axis=0),
        0.5 * (np.max((np.abs(a), np.abs(b)), axis=0) - 1.0),
    )
    return np.asarray(np.maximum(beyond, 0.0))
