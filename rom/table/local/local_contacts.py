"""What each contact does at the frequencies of one or two tones, with amplitudes of its own.

At the higher harmonics a contact responds to its own force by its own flexibility g_h; what it
does to other contacts there is of second order. Its force deficit at carrier t is then k_t x_t of
its own displacement 2 Re(sum_t x_t exp(i Omega_t t)), with secants k_t(|x_A|, |x_B|): one function
for each kind of contact, whatever the modes. On a disk the contacts of all sectors are of the same
kinds, and g_h is the mean over all nodal diameters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts

STEPS = 512  # per period of one tone
_TINY = np.finfo(float).tiny


@frozen
class _Grid:
    """Points of a table, and the accuracy of the contact problem there.

    Attributes
    ----------
    nearest, farthest : float
        Ends of past = (|x_A| + |x_B|) / onset - 1 [-]. The contacts stick before, and hardly hold
        beyond.
    nodes, shares : int
        Numbers of nodes of log(past), and of the angle whose squared tangent is |x_B| / |x_A|.
    steps, lines : int
        Of the torus, per period of the faster tone.
    march : float
        Distance from periodicity.
    """

    nearest: float
    farthest: float
    nodes: int
    shares: int
    steps: int
    lines: int
    march: float

    def points(self) -> Floats:
        """Return |x_t| / onset of the tones (shares, nodes, 2)."""
        whole = 1.0 + np.geomspace(self.nearest, self.farthest, self.nodes)
        # a tone at rest has the secant of a small amplitude
        angle = np.linspace(0.0, 0.5 * np.pi, self.shares)
        angle = np.clip(angle, _SMALLEST, 0.5 * np.pi - _SMALLEST) if self.shares > 1 else angle
        parts = np.stack((np.cos(angle), np.sin(angle)), axis=-1) ** 2
        return np.asarray(parts[:, np.newaxis] * whole[:, np.newaxis])


# On one tone, and on two. Nodes of one tone are close to one another where slip begins. Of two
# tones, forces k x between the nodes were within 1.1 % of the force of a sticking contact, and
# within 0.14 % on average; tests/rom/slow/test_two_tones.py has the effect on motions.
_GRIDS = _Grid(1e-6, 1e5, 500, 1, STEPS, 1, 1e-8), _Grid(1e-3, 1e6, 37, 17, 64, 16, 1e-6)
_SMALLEST = 0.02  # angle [rad]


@frozen
class LocalContacts:
    """The secants of each kind of contact against its displacement.

    Attributes
    ----------
    onset : (kinds,) ndarray
        |x_A| + |x_B| at which the contact begins to slip [m].
    first, spacing : float
        log((|x_A| + |x_B|) / onset - 1) at the first node, and between nodes.
    secant : (nodes, shares, kinds, tones, 2, 1 or 2, 2) ndarray
        Real and imaginary parts of k_t [N/m] at the nodes, and under two tones their derivatives
        by the angle, per spacing; each with its derivative by the logarithm, per spacing.
    """

    HIGHEST: ClassVar[int] = 15  # harmonic of one tone to which the contacts respond

    onset: Floats
    first: float
    spacing: float
    secant: Floats

    @property
    def kinds(self) -> int:
        """Number of kinds of contacts."""
        return self.onset.size

    @classmethod
    def of(
        cls,
        law: Elastic,
        at_carrier: Complexes,
        flexibility: Callable[[float], Complexes],
        frequency: Floats,
    ) -> Self:
        """Return the contacts of a law.

        Parameters
        ----------
        law : Elastic
        at_carrier : (tones, kinds) complex ndarray
            g of each contact at the carriers, with which the displacement below is the drive,
            x - g y; 0: the displacement itself.
        flexibility : callable
            Flexibility (kinds,) of each contact to its own force at a frequency [rad/s]: on one
            tone g_h of the odd harmonics h = 3, 5, ...; on two tones all harmonics have the last.
        frequency : (tones,) ndarray
            Omega [rad/s].
        """
        tones, kinds = at_carrier.shape
        grid = _GRIDS[tones - 1]
        own = dict(zip(CARRIERS, at_carrier, strict=False))
        if tones == 1:
            own |= {(h, 0): flexibility(h * frequency[0]) for h in range(3, cls.HIGHEST + 1, 2)}
        # each contact on its own
        static = np.maximum(flexibility(cls.HIGHEST * frequency[0]).real, 0.0)
        dual = DualContacts(law, np.diag(static), frequency)
        onset = _onset(law, kinds)
        coupling = np.tile(onset, (tones, 1)).astype(complex)
        problem = dual.problem(coupling, {order: np.diag(g) for order, g in own.items()})
        quick = int(np.ceil(frequency.max() / frequency[0]))
        points = grid.points()[..., :tones]
        terms = problem.on(Discretisation(quick * grid.steps, grid.lines), grid.march).solve(
            points.reshape(-1, tones)
        )
        terms.check_periodic()
        forces = terms.P[:, :tones].reshape(grid.shares, grid.nodes, tones, kinds)
        k = (forces / (points[..., np.newaxis] * onset)).transpose(1, 0, 3, 2)
        first, last = np.log([grid.nearest, grid.farthest])
        return cls(onset, first, (last - first) / (grid.nodes - 1), _with_slopes(k))

    def __call__(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y and its derivatives by x and by conj(x), at displacements x (..., tones, N_c).

        Derivatives (..., tones, tones, N_c) are of y at the first tone by x at the second one.
        Contact j is of the kind j modulo the number of kinds.
        """
        tones, count = x.shape[-2:]
        copies = (*x.shape[:-2], tones, count // self.kinds, self.kinds)
        at = np.moveaxis(x.reshape(copies), -3, -1)  # (..., kinds, tones)
        size = np.maximum(np.abs(at), _TINY)
        k, by_size = self._secants(size)
        turn = at / size
        change = 0.5 * at[..., np.newaxis] * by_size
        by_x = change * turn.conj()[..., np.newaxis, :] + k[..., np.newaxis] * np.eye(tones)
        by_conjugate = change * turn[..., np.newaxis, :]

        def contacts_last(values: Complexes, axes: int) -> Complexes:
            ends = tuple(range(-axes, 0))
            moved = np.moveaxis(values, ends, tuple(each - 2 for each in ends))
            return np.asarray(moved.reshape(*moved.shape[:-2], count))

        return contacts_last(k * at, 1), contacts_last(by_x, 2), contacts_last(by_conjugate, 2)

    def _secants(self, size: Floats) -> tuple[Complexes, Complexes]:
        """Return k (..., kinds, tones), and derivatives (..., tones, tones) of k_t by |x_u|."""
        nodes, shares, kinds, tones = self.secant.shape[:4]
        whole = size.sum(axis=-1)
        others = np.maximum(whole - size[..., 0], _TINY)
        past = np.maximum(whole / self.onset - 1.0, np.exp(self.first))
        place = np.clip((np.log(past) - self.first) / self.spacing, 0.0, nodes - 1.0)
        tangent = np.sqrt(others / size[..., 0])
        row, along = _hermite(place, nodes)
        column, across = _hermite(np.arctan(tangent) / (0.5 * np.pi) * (shares - 1), shares)
        rows = row[..., np.newaxis, np.newaxis] + np.arange(2)[:, np.newaxis]
        columns = column[..., np.newaxis, np.newaxis] + np.arange(min(shares, 2))
        cell = self.secant[rows, columns, np.arange(kinds)[:, np.newaxis, np.newaxis]]
        # value, and derivatives by both places
        terms = [(along[0], across[0]), (along[1], across[0]), (along[0], across[1])]
        weights = np.stack(
            [a[..., :, None, None, :] * b[..., None, :, :, None] for a, b in terms], axis=-5
        ).reshape(*place.shape, 3, -1)
        values = np.moveaxis(cell, (-4, -3), (-2, -1)).reshape(*place.shape, -1, 2 * tones)
        parts = (weights @ values).reshape(*place.shape, 3, tones, 2)
        k, by_log, by_angle = np.moveaxis(parts[..., 0] + 1j * parts[..., 1], -2, 0)
        sticks = past <= np.exp(self.first)
        k[sticks] = by_log[sticks] = by_angle[sticks] = 0.0
        by_log[place == nodes - 1.0] = 0.0
        by_whole = by_log / (self.spacing * past * self.onset)[..., np.newaxis]
        turn = np.stack((-tangent, 1.0 / tangent), axis=-1)[..., :tones]
        angle = turn * (max(shares - 1, 1) / np.pi / whole)[..., np.newaxis]
        by_size = by_whole[..., np.newaxis] + by_angle[..., np.newaxis] * angle[..., np.newaxis, :]
        return k, by_size


def _onset(law: Elastic, kinds: int) -> Floats:
    """Return |x| (kinds,) at which the first slider of a contact slips [m]."""
    elements, onset = law.elements(kinds), np.full(kinds, np.inf)
    limit, stiffness = elements.slider.T
    for element in elements.element:
        own = element["first_slider"] + np.arange(element["sliders"])
        onset[element["column"][0]] = 0.5 * (limit[own] / stiffness[own]).min()
    return onset


def _with_slopes(k: Complexes) -> Floats:
    """Return secants (nodes, shares, kinds, tones) with their derivatives per cell."""
    values = np.stack((k.real, k.imag), axis=-1)[..., np.newaxis]
    if k.shape[1] > 1:
        by_angle = _monotone_slopes(values, 1)
        by_angle[:, [0, -1]] = 0.0  # even in the amplitude of the tone at rest
        values = np.concatenate((values, by_angle), axis=-1)
    return np.stack((values, _monotone_slopes(values, 0)), axis=-1)


def _monotone_slopes(values: Floats, axis: int) -> Floats:
    """Return derivatives per cell at equidistant nodes, for cubics that are monotone between them.

    Inside by Fritsch and Butland, at the ends from three nodes. `scipy.interpolate` has the same
    cubics (PCHIP); its import takes longer than the rest of a plan.
    """
    change = np.diff(np.moveaxis(values, axis, 0), axis=0)
    if len(change) == 1:
        return np.moveaxis(np.concatenate((change, change)), 0, axis)
    before, after = change[:-1], change[1:]
    alike = before * after > 0.0
    mean = 2.0 * before * after / np.where(alike, before + after, 1.0)
    ends = []
    for first, second in ((change[0], change[1]), (change[-1], change[-2])):
        end = 1.5 * first - 0.5 * second
        turns = (first * second <= 0.0) & (np.abs(end) > 3.0 * np.abs(first))
        ends.append(np.where(turns, 3.0 * first, np.where(end * first > 0.0, end, 0.0)))
    return np.moveaxis(np.stack((ends[0], *np.where(alike, mean, 0.0), ends[1])), 0, axis)


def _hermite(place: Floats, nodes: int) -> tuple[NDArray[np.intp], tuple[Floats, Floats]]:
    """Return the cell of places among nodes 0, 1, ..., and the weights of a cubic polynomial.

    Weights and their derivatives are (..., 2, 2): of the value and the slope at both ends. A
    single node has the weight 1.
    """
    if nodes == 1:
        one = np.ones((*place.shape, 1, 1))
        return np.zeros(place.shape, dtype=np.intp), (one, 0.0 * one)
    cell = np.minimum(place.astype(np.intp), nodes - 2)
    t = place - cell
    u = 1.0 - t
    values = [u * u * (1.0 + 2.0 * t), u * u * t, t * t * (1.0 + 2.0 * u), -t * t * u]
    slopes = [-6.0 * t * u, u * (1.0 - 3.0 * t), 6.0 * t * u, t * (3.0 * t - 2.0)]
    value, slope = (np.stack(each, -1).reshape(*t.shape, 2, 2) for each in (values, slopes))
    return cell, (value, slope)
