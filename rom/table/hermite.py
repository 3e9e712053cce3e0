"""Friction tables: S_j = Q_j |a_j| over the amplitude plane as bicubic Hermite surfaces.

S_j, not Q_j, is tabulated: it goes smoothly to zero with |a_j|. Slopes come from cubic splines
that know the symmetry at zero amplitude: a harmonic (n, m) is odd in |a_A| where n is odd, and in
|a_B| where m is; S_A belongs to (1, 0) and S_B to (0, 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import OutsideTableError, SlipmodeError


@dataclass(frozen=True, eq=False)
class Table:
    """Bicubic Hermite surface of the friction terms.

    Attributes
    ----------
    node_a : (n_a,) ndarray
        Amplitudes |a_A| of the grid lines, from 0 [kg^1/2 m].
    node_b : (n_b,) ndarray
        Amplitudes |a_B|; the single entry 0 in a one-mode table.
    values : (n_a, n_b, 4, 2 k) ndarray
        Value, d/da, d/db, d2/dadb at the nodes; real and imaginary part of S_j of every mode,
        of the terms T of the combination resonances, and of the powers [W]: the real part is the
        friction power less the power from the modes and the forces, the imaginary part the
        power from the forces besides their shift of the amplitudes, `ContactTerms.by_forces`.
    modes : int
        Number of modes.
    rate_correction : (n_a, n_b, 4, 2 modes^2) ndarray, optional
        Likewise dS_j / d(d|a_k|/dt) [N kg^-1 s/m], by j and k: see `rate_correction`.
        Default: friction is at any time what it is in steady motion.
    detuning : (n_a, n_b, 4, 2 modes^2) ndarray, optional
        Likewise dS_j / dOmega_k at the carriers [N kg^-1/2 s]. Default: S_j is the same at all
        forcing frequencies.
    """

    node_a: Floats
    node_b: Floats
    values: Floats
    modes: int
    rate_correction: Floats | None = None
    detuning: Floats | None = None

    def __repr__(self) -> str:
        nodes = " x ".join(str(node.size) for node in (self.node_a, self.node_b)[: self.modes])
        reach = ", ".join(f"{largest:.4g}" for largest in self.amplitude_range)
        return f"Table({nodes} nodes to {reach})"

    @property
    def amplitude_range(self) -> Floats:
        """Largest tabulated amplitude of each mode, (modes,)."""
        return np.array([self.node_a[-1], self.node_b[-1]][: self.modes])

    @property
    def axes(self) -> tuple[Floats, ...]:
        """The nodes of each mode, one entry per mode."""
        return (self.node_a, self.node_b)[: self.modes]

    def nodes(self) -> Complexes:
        """Values at the nodes, (n_a, n_b, k)."""
        values: Complexes = np.ascontiguousarray(self.values[:, :, 0]).view(complex)
        return values

    def kernel(self) -> kernel.Structure:
        """The table as the core reads it."""
        columns = self.values.shape[-1] // 2
        power = int(columns > self.modes)
        node_b = self.node_b if self.modes == 2 else None
        arrays = {"node_a": self.node_a, "node_b": node_b, "values": self.values}
        arrays |= {"rate_correction": self.rate_correction, "detuning": self.detuning}
        return kernel.Table(
            modes=self.modes,
            combinations=columns - self.modes - power,
            power=power,
            count_a=self.node_a.size,
            count_b=self.node_b.size,
            **{name: kernel.contiguous(a) for name, a in arrays.items() if a is not None},
        )

    def __call__(self, amplitudes: ArrayLike) -> Complexes:
        """S_j, shape (..., modes), at amplitudes (..., modes) >= 0 inside the table."""
        return self.terms(amplitudes)[..., : self.modes]

    def rate_correction_at(self, amplitudes: ArrayLike) -> Complexes:
        """dS_j / d(d|a_k|/dt), (..., modes, modes), at amplitudes (..., modes) >= 0."""
        return self._correction_at(self.rate_correction, amplitudes)

    def detuning_at(self, amplitudes: ArrayLike) -> Complexes:
        """dS_j / dOmega_k, (..., modes, modes), at amplitudes (..., modes) >= 0."""
        return self._correction_at(self.detuning, amplitudes)

    def _correction_at(self, values: Floats | None, amplitudes: ArrayLike) -> Complexes:
        if values is None:
            return np.zeros((*np.shape(amplitudes), self.modes), dtype=complex)
        surface = Table(self.node_a, self.node_b, values, self.modes)
        terms = surface.terms(amplitudes)
        return terms.reshape(*terms.shape[:-1], self.modes, self.modes)

    def terms(self, amplitudes: ArrayLike) -> Complexes:
        """All columns of `values`, (..., k), at amplitudes (..., modes) >= 0.

        Raises
        ------
        SlipmodeError
            Outside the table: it is never extrapolated.
        """
        points = kernel.contiguous(amplitudes)
        if points.ndim == 0 or points.shape[-1] != self.modes:
            raise SlipmodeError(f"amplitudes: the last axis must have length {self.modes}")
        result = np.empty((*points.shape[:-1], self.values.shape[-1] // 2), dtype=complex)
        count = points.size // self.modes
        status = kernel.lib.sm_table_lookup(self.kernel(), count, points, result)
        if status == kernel.OUTSIDE_TABLE:
            raise outside_table(points, self)
        kernel.check(status, "table look-up")
        return result


def outside_table(amplitudes: Floats, table: Table, limit_scale: float = 1.0) -> SlipmodeError:
    """Return the refusal of effective amplitudes that are outside a table, or about to leave it.

    Parameters
    ----------
    amplitudes : (..., modes) ndarray
        Moduli |a_j| as the contacts see them [kg^1/2 m]. The message names the mode that is
        furthest outside.
    limit_scale : float
        Factor on the friction limits of the table [-]: its range grows with them.
    """
    largest, ends = amplitudes.reshape(-1, table.modes).max(axis=0), table.amplitude_range
    ends = limit_scale * ends
    j = int(np.argmax(largest / ends))
    reached, end = float(largest[j]), float(ends[j])
    if reached > end:
        shown = f"{reached:.4g}" if reached > 1.001 * end else repr(reached)
        what = f"mode {'AB'[j]} reaches {shown} kg^1/2 m at the contacts,"
    else:  # a search that was held inside the table
        what = f"mode {'AB'[j]} goes"
    return OutsideTableError(
        f"amplitude: {what} outside the friction table, which ends at {end:.6g} kg^1/2 m; "
        "tabulate a larger range"
    )


def make_table(
    node_a: Floats,
    node_b: Floats,
    samples: Complexes,
    orders: Sequence[tuple[int, int]],
    loss: Floats,
) -> Table:
    """Table through samples (n_a, n_b, k) of harmonics `orders`; n_b = 1 for one mode.

    Parameters
    ----------
    loss : (modes,) ndarray
        Structural loss gamma_j Omega_j of each mode. Where mode and contacts together lose energy
        at every node of a cell, loss |a_j| - Im S_j >= 0, they do so between them too. Where the
        power |a_A| (loss |a_A| - Im S_A) of one mode increases from node to node, it does so
        between them too. The slopes of the dissipative parts are limited for this.
    """
    modes = 1 if node_b.size == 1 else 2
    f, f_a, f_b, f_ab = _with_slopes(node_a, node_b, samples, orders)
    for j in range(modes):
        own = (node_a[:, np.newaxis], node_b[np.newaxis, :])[j]
        gain = np.array([loss[j] * (j == mode) for mode in range(2)])
        im = (..., j, 1)
        values = f[im] - loss[j] * own
        slopes = [f_a[im] - gain[0], f_b[im] - gain[1], f_ab[im]]
        if modes == 1:
            slopes[0] = _limit_power(node_a, values, slopes[0])
        limited = _limit_slopes(node_a, node_b, values, *slopes)
        f_a[im], f_b[im], f_ab[im] = limited[0] + gain[0], limited[1] + gain[1], limited[2]
    return Table(node_a, node_b, _side_by_side(f, f_a, f_b, f_ab), modes)


def surface_values(
    node_a: Floats,
    node_b: Floats,
    samples: Complexes,
    orders: Sequence[tuple[int, int]],
    monotone: bool = False,
) -> Floats:
    """Values and slopes (n_a, n_b, 4, 2 k) through samples of any sign, as in `make_table`.

    If `monotone`, values between two nodes of a grid line are between the values at these.
    """
    return _side_by_side(*_with_slopes(node_a, node_b, samples, orders, monotone))


def _with_slopes(
    node_a: Floats,
    node_b: Floats,
    samples: Complexes,
    orders: Sequence[tuple[int, int]],
    monotone: bool = False,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Samples and their d/da, d/db, d2/dadb at the nodes, each (n_a, n_b, k, 2)."""
    odd_a, odd_b = (np.array(orders) % 2 == 1).T
    f = np.ascontiguousarray(samples).view(float).reshape(*samples.shape, 2)
    f_a = _slopes(node_a, odd_a, f, monotone)
    f_b, f_ab = np.zeros_like(f), np.zeros_like(f)
    if node_b.size > 1:
        along = np.concatenate((f, f_a), axis=2).swapaxes(0, 1)
        slopes_b = _slopes(node_b, np.tile(odd_b, 2), along, monotone)
        f_b, f_ab = np.split(slopes_b.swapaxes(0, 1), 2, axis=2)
    return f, f_a, f_b, f_ab


def _side_by_side(*parts: Floats) -> Floats:
    values = np.stack(parts, axis=2)
    return values.reshape(*values.shape[:3], -1)


def _slopes(node: Floats, odd: Flags, values: Floats, monotone: bool) -> Floats:
    """Slopes at the nodes of cubic splines along the first axis of values (n, ..., k, 2).

    The splines are odd (k,) or even about node = 0 and not-a-knot at the far end. If `monotone`,
    slopes are limited to three times the slopes of the chords (Fritsch and Carlson 1980).
    """
    n = node.size
    if n < 4:
        raise SlipmodeError("a friction table needs at least four amplitudes per mode")
    step = np.diff(node)
    wide = step.reshape(-1, *(values.ndim - 1) * [1])
    rise = np.diff(values, axis=0) / wide
    # continuous second derivative: row i holds for the slopes at i - 1, i and i + 1
    right = np.zeros_like(values)
    right[0, ..., odd, :] = 1.5 * rise[0, ..., odd, :]
    right[1:-1] = 3.0 * (wide[1:] * rise[:-1] + wide[:-1] * rise[1:])
    right[-1] = np.tensordot(_end_weights(node[-4:]), values[-4:], axes=1)
    lower, upper = np.append(step[1:], 0.0), np.append(0.0, step[:-1])
    diagonal = np.concatenate(([1.0], 2.0 * (step[1:] + step[:-1]), [1.0]))
    found = np.empty_like(values)
    for uneven in (False, True):
        if not (same := odd == uneven).any():
            continue
        some = right[..., same, :]
        upper[0] = 0.5 * uneven
        *_, slopes, _ = scipy.linalg.lapack.dgtsv(lower, diagonal, upper, some.reshape(n, -1))
        found[..., same, :] = slopes.reshape(some.shape)
    if monotone:
        for end in (slice(None, -1), slice(1, None)):  # of each cell
            found[end] = np.clip(found[end], np.minimum(3.0 * rise, 0), np.maximum(3.0 * rise, 0))
    return found


def _end_weights(node: Floats) -> Floats:
    """Weights (4,) of four values in the slope at the last node of the cubic through them."""
    *others, last = node.tolist()
    weights = []
    for own in others:
        rest = [other for other in others if other != own]
        shape = prod((last - other) / (own - other) for other in rest)
        weights.append(shape / (own - last))
    return np.array([*weights, -sum(weights)])


# Of the smaller loss D of two nodes: the least slope of the power |a| D between them.
_LEAST_POWER_SLOPE = 0.5


def _limit_power(node: Floats, f: Floats, slope: Floats) -> Floats:
    """Slopes along the first axis for which -node f increases in each cell as it does at nodes.

    A spline oscillates across a kink of f at the onset of slip, and steady states of one mode are
    unstable where the power -node f decreases. It increases if g = f - c node decreases, with
    c = min(-f) / 2 / node. The cubic g decreases if its slopes at both ends are between 0 and
    three times the slope of its chord (Fritsch and Carlson 1980).
    """
    node = node[:, np.newaxis]
    c = (_LEAST_POWER_SLOPE - 1.0) * np.maximum(f[:-1], f[1:]) / node[1:]
    chord = np.diff(f, axis=0) / np.diff(node, axis=0) - c
    increases = (c >= 0.0) & (chord <= 0.0)
    lower, upper = np.full_like(f, -np.inf), np.full_like(f, np.inf)
    for end in (slice(None, -1), slice(1, None)):  # of each cell
        lower[end] = np.maximum(lower[end], np.where(increases, 3.0 * chord + c, -np.inf))
        upper[end] = np.minimum(upper[end], np.where(increases, c, np.inf))
    return np.clip(slope, lower, upper)


def _limit_slopes(
    node_a: Floats, node_b: Floats, f: Floats, f_a: Floats, f_b: Floats, f_ab: Floats
) -> tuple[Floats, Floats, Floats]:
    """Slopes for which the bicubic through f <= 0 stays <= 0 in every cell.

    A cell is <= 0 if its sixteen Bernstein coefficients are. Those next to a node are
    f +- h_a f_a / 3, f +- h_b f_b / 3 and f +- h_a f_a / 3 +- h_b f_b / 3 + h_a h_b f_ab / 9
    (with the signs of the quadrant). Half of f pays for each of f_a and f_b, what is left over
    for f_ab.
    """
    f, steps_a = np.minimum(f, 0.0), _neighbour_steps(node_a)
    f_a = _clip(f_a, f, steps_a[:, :, np.newaxis])
    if node_b.size == 1:
        return f_a, f_b, f_ab
    steps_b = _neighbour_steps(node_b)
    f_b = _clip(f_b, f, steps_b[:, np.newaxis, :])
    h_a, h_b = steps_a[:, np.newaxis, :, np.newaxis], steps_b[:, np.newaxis]  # the quadrants
    room = np.minimum(f + h_a * f_a / 3.0 + h_b * f_b / 3.0, 0.0)
    area = h_a * h_b / 9.0
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = np.where(area == 0.0, np.inf, -room / np.abs(area))
    # the twist must not lift its quadrant's coefficient above zero
    highest = np.where(area > 0.0, bound, np.inf).min(axis=(0, 1))
    lowest = np.where(area > 0.0, -np.inf, -bound).max(axis=(0, 1))
    return f_a, f_b, np.clip(f_ab, lowest, highest)


def _neighbour_steps(node: Floats) -> Floats:
    """(2, n): signed distance to the next and to the previous node, 0 where there is none."""
    gaps = np.diff(node)
    return np.stack((np.append(gaps, 0.0), -np.append(0.0, gaps)))


def _clip(slope: Floats, f: Floats, steps: Floats) -> Floats:
    """Slope with f / 2 + h slope / 3 <= 0 for the steps h to both neighbours."""
    forward, backward = steps
    with np.errstate(divide="ignore", invalid="ignore"):
        upper = np.where(forward == 0.0, np.inf, -1.5 * f / forward)
        lower = np.where(backward == 0.0, -np.inf, -1.5 * f / backward)
    return np.clip(slope, lower, upper)
