"""Combination resonances: harmonics of the contact motion near the carrier of a mode.

If n Omega_A + m Omega_B is near Omega_j, the nonresonant response of mode j would have a small
denominator. Such a harmonic drives the slow flow of mode j instead, by
T exp(i (n t_A + m t_B - theta_j)) with T = -L_j^T P_nm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Flags, as_floats
from slipmode.rom.errors import SlipmodeError

# Distance from a carrier, relative to it, below which harmonics up to |n| + |m| are near it. A
# harmonic of higher order is smaller, and drives as much only at a smaller distance.
SEPARATION = {7: 0.1, 9: 0.01}
# The same for transients, of all these orders: the response of a mode to a near harmonic is not
# steady while free vibrations decay. Without orders 8 and 9 a mode was 2 % off after steps of the
# force (tests/runner/transients/test_combination_resonances.py).
TRANSIENT_SEPARATION = 0.1
MOST = 16  # combination resonances in the core's arrays
_MOST_NEAR = 8  # of two tones: later ones are of high order, and each adds a column to the table
# Largest |n| + |m| of the harmonics that drive modes on one tone: up to 9 a published resonance
# 1:3 was 0.7 % off, up to 15 it is 0.2 % off
# (tests/rom/slow/branches/test_internal_resonances.py).
_HIGHEST_LOCKED = 15
_HIGHEST = 31  # |n| and |m| that grids of 64 phase lines distinguish; the finest has 128

Order = tuple[int, int]
CARRIERS: tuple[Order, ...] = ((1, 0), (0, 1))  # harmonics of modes A and B


@dataclass(frozen=True)
class CombinationResonance:
    """Name a harmonic (n, m) of the contact forces near the carrier of a mode.

    Attributes
    ----------
    mode : int
        Mode near the harmonic: 0 for A, 1 for B.
    n, m : int
        Orders of the frequency n Omega_A + m Omega_B, -31 to 31.

    Raises
    ------
    SlipmodeError
        If a value is outside its range, or (n, m) is the carrier of the mode itself.
    """

    mode: int
    n: int
    m: int

    def __post_init__(self) -> None:
        if self.mode not in (0, 1):
            raise SlipmodeError(f"mode: must be 0 or 1, got {self.mode!r}")
        for key, value in (("n", self.n), ("m", self.m)):
            if not isinstance(value, int | np.integer) or abs(value) > _HIGHEST:
                raise SlipmodeError(
                    f"{key}: must be an integer from {-_HIGHEST} to {_HIGHEST}, got {value!r}"
                )
        if (self.n, self.m) == CARRIERS[self.mode]:
            raise SlipmodeError(
                f"n, m: ({self.n}, {self.m}) is the carrier of mode {'AB'[self.mode]}, "
                "not a combination"
            )

    def __str__(self) -> str:
        return f"{self.n:+d} A {self.m:+d} B"

    @property
    def stored_order(self) -> Order:
        """Order (n, m) or (-n, -m) whose coefficient is computed; the other has the conjugate."""
        order = (self.n, self.m)
        return order if order > (0, 0) else (-self.n, -self.m)


def harmonic_orders(highest: int, modes: int, even: bool = False) -> list[Order]:
    """Return one of each +-(n, m) with |n| + |m| <= highest: the carriers first, then by order.

    Friction under constant load is odd, so that P_nm = 0 for even n + m. These, with the mean
    after the carriers, are returned if `even`.
    """
    span = range(-highest, highest + 1)
    orders = [
        (n, m)
        for n in range(highest + 1)
        for m in (span if modes == 2 else (0,))
        if (n, m) >= (0, 0) and abs(n) + abs(m) <= highest and (even or (n + m) % 2)
    ]

    def rank(order: Order) -> tuple[int, bool, int, int]:
        n, m = order
        return max(abs(n) + abs(m), 1), order == (0, 0), -n, -m

    return sorted(orders, key=rank)


def _separation(order: Order) -> float:
    """Return the relative distance from a carrier below which a harmonic is near it."""
    highest = abs(order[0]) + abs(order[1])
    return max(distance for most, distance in SEPARATION.items() if highest <= most)


def combination_resonances(
    frequencies: ArrayLike,
    until: ArrayLike | None = None,
    even: bool = False,
    transient: bool = False,
) -> tuple[CombinationResonance, ...]:
    """Return harmonics n Omega_A + m Omega_B near a carrier, for pairs of forcing frequencies.

    A harmonic is near within 10 % of the carrier up to |n| + |m| = 7, and within 1 % up to 9. The
    carrier of the other mode is none: the mode responds to it in the contact problem.

    Parameters
    ----------
    frequencies : (points, modes) array_like
        Forcing frequencies [rad/s], > 0.
    until : (points, modes) array_like, optional
        End points of straight sweeps that begin at `frequencies` [rad/s]. A harmonic that crosses
        a carrier during a sweep is included.
    even : bool, default False
        Include harmonics with even n + m, for contacts with varying normal force.
    transient : bool, default False
        Take 10 % for |n| + |m| = 8 and 9 as well, for models of transients. In steady states the
        contact problem has the response to these harmonics.

    Returns
    -------
    tuple of CombinationResonance
        At most 8, of lowest order first; empty for one mode.

    Raises
    ------
    SlipmodeError
        If a frequency is not positive, or an array has a wrong shape.

    Examples
    --------
    With frequencies 1:3, the third harmonic of A is at the carrier of B:

    >>> rom.combination_resonances([[1.0, 3.0]])[0]
    CombinationResonance(mode=1, n=3, m=0)
    """
    start = np.atleast_2d(as_floats("frequencies", frequencies))
    end = start if until is None else np.atleast_2d(as_floats("until", until))
    for key, points in (("frequencies", start), ("until", end)):
        fits = points.ndim == 2 and points.shape[1] in (1, 2) and points.shape == start.shape
        if not (fits and np.isfinite(points).all() and (points > 0.0).all()):
            raise SlipmodeError(
                f"{key}: must be finite numbers > 0 of shape (points, modes), of one or two modes "
                "[rad/s]"
            )
    if start.shape[1] == 1:
        return ()
    ends = np.unique(np.stack((start, end), axis=1), axis=0)  # (sweeps, 2, modes)
    orders = [
        (sign * n, sign * m)
        for n, m in harmonic_orders(max(SEPARATION), 2, even)
        for sign in (1, -1)
    ]
    nu = ends @ np.array(orders).T  # (sweeps, 2, orders)
    apart = nu[..., np.newaxis] - ends[:, :, np.newaxis]  # (sweeps, 2, orders, modes)
    distances = [TRANSIENT_SEPARATION if transient else _separation(order) for order in orders]
    within = np.array(distances)[:, np.newaxis]
    close = (np.abs(apart) < within * ends[:, :, np.newaxis]).any(axis=(0, 1))
    passed = (apart[:, 0] * apart[:, 1] < 0.0).any(axis=0)
    found = [
        CombinationResonance(int(mode), *orders[k])
        for k, mode in np.argwhere(close | passed)
        if sum(map(abs, orders[k])) > 1
    ]
    return tuple(found[:_MOST_NEAR])


def locked_resonances(ratio: Fraction, even: bool = False) -> tuple[CombinationResonance, ...]:
    """Return the harmonics at the carriers of two modes on one tone, Omega_B = ratio Omega_A.

    At most 16, of lowest order first; with even n + m only if `even`.
    """
    p, q = ratio.numerator, ratio.denominator
    return tuple(
        CombinationResonance(mode, sign * n, sign * m)
        for n, m in harmonic_orders(_HIGHEST_LOCKED, 2, even)
        for sign in (1, -1)
        for mode, carrier in enumerate((q, p))
        if sign * (n * q + m * p) == carrier and (sign * n, sign * m) != CARRIERS[mode]
    )[:MOST]


def resonant_modes(
    modes: int, orders: Sequence[Order], combinations: Sequence[CombinationResonance]
) -> Flags:
    """Return which modes have each harmonic in their slow flow, (orders, modes).

    As their carrier, or as a combination resonance.
    """
    resonant = {(mode, CARRIERS[mode]) for mode in range(modes)}
    resonant |= {(term.mode, term.stored_order) for term in combinations}
    flags = [[(mode, order) in resonant for mode in range(modes)] for order in orders]
    return np.array(flags, dtype=bool).reshape(len(orders), modes)


def tabulated_orders(combinations: Sequence[CombinationResonance], modes: int) -> list[Order]:
    """Return the harmonics in a table: the carriers, the combination resonances, the mean."""
    return [*CARRIERS[:modes], *((term.n, term.m) for term in combinations), (0, 0)]
