"""Where samples of a friction table come from, what they hold, how far a table is off them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.short_repr import short_repr
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
        The mode that each column but the power drives: its largest |S_j| is the column's scale.
    swing : (modes,) ndarray
        2 Omega_j |a_j| at the largest amplitude: the scale of the power is what the largest S_j
        would take, not the power itself, which weak friction leaves to the rounding.
    least : (modes,) ndarray
        Below it |S_j| is rounding, which cannot be tabulated relative to itself.
    loss : (modes,) ndarray
        Structural loss of each mode, see `make_table`.
    carried : int
        Further columns that are neither tabulated nor refined: samples nearby begin with them.
    kept : bool
        Whether these are wanted at the nodes of the finished table, too.
    """

    orders: tuple[Order, ...]
    drives: tuple[int, ...]
    swing: Floats
    least: Floats
    loss: Floats
    carried: int = 0
    kept: bool = False

    __repr__ = short_repr

    def scale(self, S: Complexes) -> Floats:
        """What errors of the tabulated columns are relative to, of values (..., columns)."""
        largest = np.abs(S[..., : self.swing.size]).max(axis=tuple(range(S.ndim - 1)))
        largest = np.maximum(largest, self.least)
        scale = np.append(largest[list(self.drives)], self.swing @ largest)
        return np.where(scale > 0.0, scale, 1.0)


@dataclass(frozen=True, eq=False)
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

    __repr__ = short_repr

    def doubts(self, table: Table) -> Floats:
        """How little its neighbours along each mode's axis tell of a node, (modes, n_a, n_b)."""
        S, scale = table.nodes(), self.scale(table)
        parts = [unpredicted(table.node_a, S)]
        if table.modes == 2:
            parts.append(unpredicted(table.node_b, S.swapaxes(0, 1)).swapaxes(0, 1))
        return np.array([(part / scale).max(axis=-1) for part in parts])

    def table(self, axes: tuple[Floats, Floats], tabulated: Complexes) -> Table:
        """Table through the tabulated columns on a grid."""
        orders, loss = self.columns.orders, self.columns.loss
        return make_table(axes[0], axes[1], tabulated, orders, loss)

    def error_of(self, surface: Complexes, exact: Complexes, scale: Floats) -> Floats:
        """Relative error of values of a table of such a scale where samples are `exact`."""
        tabulated = exact[..., : len(self.columns.orders)]
        return np.asarray((np.abs(surface - tabulated) / scale).max(axis=-1))

    def scale(self, table: Table) -> Floats:
        """What errors of a table are relative to: its values up to the amplitude range."""
        inside = [
            np.searchsorted(node, end, "right")
            for node, end in zip(table.axes, self.amplitude_range, strict=True)
        ]
        return self.columns.scale(table.nodes()[tuple(slice(count) for count in inside)])


def amplitude_pairs(node_a: Floats, node_b: Floats, modes: int) -> Floats:
    """Amplitudes (n_a n_b, modes) of a grid; of one mode, those of the first axis."""
    pairs = np.empty((node_a.size, node_b.size, modes))
    for mode, node in enumerate((node_a[:, np.newaxis], node_b)[:modes]):
        pairs[..., mode] = node
    return pairs.reshape(-1, modes)
