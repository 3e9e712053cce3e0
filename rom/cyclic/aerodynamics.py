"""Aerodynamic forces between blades: influence coefficients by distance or by nodal diameter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import SlipmodeError
from slipmode.rom.common import (
    ALLOWED,
    Complexes,
    as_complexes,
    as_floats,
    fits,
    frozen,
    in_one_line,
)
from slipmode.rom.structure import Matrix


@frozen
class Aerodynamics:
    """Aerodynamic forces on the blades of a disk, see `CyclicStructure.with_aerodynamics`.

    Attributes
    ----------
    directions : (n, m) CSC matrix
        D, which reduces the displacements of a sector to q_j = D^T u_j.
    influence : mapping of int to (m, m) complex ndarray
        l_d by distance d.
    frequency : float
        omega_0 [rad/s].
    """

    directions: Matrix
    influence: Mapping[int, Complexes]
    frequency: float

    @classmethod
    def of(
        cls, directions: Matrix, influence: Mapping[int, ArrayLike], frequency: float, sectors: int
    ) -> Self:
        """Return the forces, checked, on a disk of so many sectors."""
        if not 0.0 < as_floats("frequency", frequency) < np.inf:
            raise SlipmodeError(f"frequency: must be > 0 rad/s, got {in_one_line(frequency)}")
        size = directions.shape[1]
        read: dict[int, Complexes] = {}
        for distance, given in influence.items():
            if not isinstance(distance, int | np.integer) or abs(distance) >= sectors:
                raise SlipmodeError(
                    f"influence: distances must be integers from {1 - sectors} to {sectors - 1}, "
                    f"got {in_one_line(distance)}"
                )
            value = as_complexes("influence", given)
            if value.shape not in ((), (size, size)) or not fits(np.abs(value)):
                raise SlipmodeError(
                    f"influence: must be a finite number, or {size} x {size} of them, for each "
                    f"distance, {ALLOWED}, got {in_one_line(given)}"
                )
            read[int(distance)] = np.asarray(value * np.eye(size) if value.ndim == 0 else value)
        return cls(directions, read, float(frequency))

    def of_diameter(self, angle: float) -> tuple[Complexes, Complexes]:
        """Return stiffness and damping of q (m, m), from the phase of the next sector [rad]."""
        size = self.directions.shape[1]
        turns = np.exp(1j * angle * np.array(list(self.influence)))
        every = np.reshape(list(self.influence.values()), (-1, size, size))
        damping = np.tensordot(turns, every.imag / self.frequency, 1)
        return np.tensordot(turns, every.real, 1), damping


def influence_coefficients(by_diameter: Mapping[int, complex], sectors: int) -> dict[int, complex]:
    """Return influence coefficients l_d from aerodynamic coefficients c_k of nodal diameters.

    They are related by c_k = sum_d l_d exp(i k d 2 pi / N).

    Parameters
    ----------
    by_diameter : {k: complex}
        Coefficient c_k of every nodal diameter k from -((N - 1) // 2) to N // 2, in any unit.
    sectors : int
        Number of sectors N.

    Returns
    -------
    dict of int to complex
        Influence l_d by the distance d of the blades, in the unit of c_k.

    Raises
    ------
    SlipmodeError
        If a nodal diameter is missing or given twice.
    """
    diameters = np.array(list(by_diameter))
    given = np.array(list(by_diameter.values()), dtype=complex)
    if not np.array_equal(np.sort(diameters % sectors), np.arange(sectors)):
        raise SlipmodeError(
            f"by_diameter: must have each of the {sectors} nodal diameters once, got "
            f"{in_one_line(sorted(by_diameter))}"
        )
    distances = np.arange(sectors) - (sectors - 1) // 2
    turns = np.exp(-2j * np.pi * np.outer(distances, diameters) / sectors)
    return dict(zip(distances.tolist(), (turns @ given / sectors).tolist(), strict=True))
