"""Harmonics of the contact motion over the amplitude plane, Eq. (14): fast motion from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order


@dataclass(frozen=True, eq=False)
class Harmonics:
    """P_nm of the contact displacement at the nodes of a friction table, Eq. (14).

    Attributes
    ----------
    axes : tuple of ndarray
        The table's nodes of each mode.
    orders : tuple of (n, m)
    P : (n_a, [n_b,] orders, N_c) complex ndarray
        [m]
    left_out : (n_a, [n_b,] N_c) ndarray
        RMS of the contact displacement beyond these harmonics [m]: their truncation error.
    """

    axes: tuple[Floats, ...]
    orders: tuple[Order, ...]
    P: Complexes
    left_out: Floats

    def __repr__(self) -> str:
        nodes = " x ".join(str(axis.size) for axis in self.axes)
        return f"Harmonics({len(self.orders)} to order {self.highest}, {nodes} nodes)"

    @property
    def highest(self) -> int:
        """Largest |n| + |m| of the orders."""
        return max(abs(n) + abs(m) for n, m in self.orders)

    def at(self, amplitude: Complexes) -> Complexes:
        """P_nm exp(i (n arg a_A + m arg a_B)) (points, orders, N_c), linear between the nodes."""
        modulus = np.abs(amplitude)
        P = self._interpolated(self.P, modulus)
        unit = np.divide(amplitude, modulus, out=np.ones_like(amplitude), where=modulus > 0)
        powers = np.array(self.orders)[:, : len(self.axes)]
        rotated: Complexes = P * np.prod(unit[:, np.newaxis] ** powers, axis=2)[..., np.newaxis]
        return rotated

    def truncation(self, amplitude: Complexes) -> Floats:
        """RMS of the contact displacement that the harmonics leave out (points, N_c) [m]."""
        return np.asarray(self._interpolated(self.left_out, np.abs(amplitude)).real)

    def _interpolated(self, values: np.ndarray, modulus: Floats) -> np.ndarray:
        """Linear in each amplitude between the nodes of its cell; beyond the last as there."""
        cells, parts = [], []
        for axis, along in zip(self.axes, modulus.T, strict=True):
            inside = np.minimum(along, axis[-1])
            cell = np.clip(np.searchsorted(axis, inside, side="right") - 1, 0, axis.size - 2)
            part = (inside - axis[cell]) / (axis[cell + 1] - axis[cell])
            cells.append(cell)
            parts.append((1.0 - part, part))
        result = np.zeros((len(modulus), *values.shape[len(cells) :]), dtype=values.dtype)
        for corner in product((0, 1), repeat=len(cells)):
            weight = np.prod([part[k] for part, k in zip(parts, corner, strict=True)], axis=0)
            nodes = tuple(cell + k for cell, k in zip(cells, corner, strict=True))
            result += weight.reshape(-1, *(1,) * (result.ndim - 1)) * values[nodes]
        return result


def left_out(orders: Sequence[Order], P: Complexes, mean_square: Floats) -> Floats:
    """RMS beyond harmonics P (..., orders, N_c) of a motion of a `mean_square` (..., N_c)."""
    weight = np.array([4.0 if order == (0, 0) else 2.0 for order in orders])
    known = np.einsum("q,...qc->...c", weight, np.abs(P) ** 2)
    return np.asarray(np.sqrt(np.maximum(mean_square - known, 0.0)))
