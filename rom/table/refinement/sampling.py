"""Where samples of a friction table come from, what they hold, how far a table is off them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.error_norm import SMALLEST_SHARE, ErrorNorm
from slipmode.rom.reduction.combination import Order
from slipmode.rom.short_repr import frozen, short_repr
from slipmode.rom.table.check_points import unpredicted
from slipmode.rom.table.hermite import Table, make_table


@dataclass(frozen=True)
class Columns:
    """What a sample holds.

    Attributes
    ----------
    orders : tuple of (n, m)
        Harmonics behind the tabulated columns: S_j of the modes first, the power last.
    drives : tuple of int
        The mode that each column but the power drives: the scale of its S_j is the column's.
    norm : ErrorNorm
        Of S_j, before any is known.
    swing : (modes,) ndarray
        2 Omega_j: an error of S_j changes the power by this times |a_j| [rad/s].
    loss : (modes,) ndarray
        Structural loss of each mode, see `make_table`.
    carried : int
        Further columns that are neither tabulated nor refined: samples nearby begin with them.
    kept : bool
        Whether these are wanted at the nodes of the finished table, too.
    """

    orders: tuple[Order, ...]
    drives: tuple[int, ...]
    norm: ErrorNorm
    swing: Floats
    loss: Floats
    carried: int = 0
    kept: bool = False

    __repr__ = short_repr

    def errors(
        self, norm: ErrorNorm, points: Floats, off: Complexes | Floats, exact: Complexes
    ) -> Floats:
        """Return the largest relative error (...,) of the tabulated columns.

        Parameters
        ----------
        norm : ErrorNorm
        points : (..., modes) ndarray
            Amplitudes [kg^1/2 m].
        off, exact : (..., columns) complex ndarray
            Error and value of the columns. Errors at amplitudes that are too small to be part of
            what a table states are 0.
        """
        scale = norm.scale(points, exact[..., : self.swing.size])
        power = (scale * points * self.swing).sum(axis=-1, keepdims=True)
        power = np.where(power > 0.0, power, 1.0)
        relative = np.abs(off) / np.concatenate((scale[..., list(self.drives)], power), axis=-1)
        return np.where(norm.share(points) < SMALLEST_SHARE, 0.0, relative.max(axis=-1))


@frozen
class Sampling:
    """Where samples come from: values (points, columns) at amplitudes (points, modes).

    They are taken from about what the columns that are carried are there, if that is known.
    `onset_lines` (lines, modes) is where they may have kinks, see `onset_lines`; `noise` by how
    much they are off by chance, as errors are.
    """

    at: Callable[[Floats, Complexes | None], Complexes]
    columns: Columns
    amplitude_range: Floats
    onset_lines: Floats
    noise: float

    def norm(self, table: Table) -> ErrorNorm:
        """Return the norm with the largest |S_j| at the nodes of a table."""
        return self.columns.norm.known(table.nodes())

    def indicators(self, table: Table) -> Floats:
        """How little its neighbours along each mode's axis tell of a node, (modes, n_a, n_b)."""
        S = table.nodes()
        points = amplitude_pairs(table.node_a, table.node_b, table.modes)
        points = points.reshape(*S.shape[:2], -1)
        parts = [unpredicted(table.node_a, S)]
        if table.modes == 2:
            parts.append(unpredicted(table.node_b, S.swapaxes(0, 1)).swapaxes(0, 1))
        norm = self.norm(table)
        return np.array([self.columns.errors(norm, points, part, S) for part in parts])

    def table(self, axes: tuple[Floats, Floats], tabulated: Complexes) -> Table:
        """Table through the tabulated columns on a grid."""
        orders, loss = self.columns.orders, self.columns.loss
        return make_table(axes[0], axes[1], tabulated, orders, loss)

    def error_of(
        self, points: Floats, surface: Complexes, exact: Complexes, norm: ErrorNorm
    ) -> Floats:
        """Return the relative error (...,) of a surface (..., columns), `exact` in samples."""
        tabulated = exact[..., : len(self.columns.orders)]
        return self.columns.errors(norm, points, surface - tabulated, tabulated)


def amplitude_pairs(node_a: Floats, node_b: Floats, modes: int) -> Floats:
    """Amplitudes (n_a n_b, modes) of a grid; of one mode, those of the first axis."""
    pairs = np.empty((node_a.size, node_b.size, modes))
    for mode, node in enumerate((node_a[:, np.newaxis], node_b)[:modes]):
        pairs[..., mode] = node
    return pairs.reshape(-1, modes)
