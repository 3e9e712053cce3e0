"""The periodic motion of the contacts on the torus, Eqs. (13), (14), by characteristics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.torus.grid import Discretisation, closed_lines
from slipmode.rom.contact.torus.marched_modes import MarchedModes
from slipmode.rom.contact.torus.problem import torus_problem
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CARRIERS, CombinationResonance, Order
from slipmode.rom.reduction.force_response import steady_coupling, steady_reaction
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.short_repr import short_repr

_MAX_PERIODS = 400
_OFF = 3.0  # of the tolerance of marches: the ratio, which moves S by about a third of that


@dataclass(frozen=True, eq=False)
class ContactHarmonics:
    """Periodic contact motion at several amplitudes.

    Attributes
    ----------
    P : (points, orders, N_c) complex ndarray
        Fourier coefficients of the contact displacement [m], Eq. (14).
    mean_square : (points, N_c) ndarray
        Of the contact displacement [m^2].
    residual : (points,) ndarray
        Estimated distance from periodicity, relative to the frictionless displacement.
    marched : (points,) ndarray of int
        Time steps marched along each phase line.
    """

    P: Complexes
    mean_square: Floats
    residual: Floats
    marched: NDArray[np.int32]

    __repr__ = short_repr


def reaction_stiffnesses(
    reduced: Reduced, orders: tuple[Order, ...], combinations: tuple[CombinationResonance, ...]
) -> Complexes:
    """H of several harmonics, (orders, N_c, N_c), with the force that holds a steady state."""
    reaction = reaction_stiffness(reduced, orders, combinations)
    if reduced.force_patterns is not None:
        reaction = reaction.copy()
        for carrier, steady in zip(CARRIERS, steady_reaction(reduced), strict=False):
            if carrier in orders:
                reaction[orders.index(carrier)] += steady
    return reaction


@lru_cache(maxsize=8)
def _marched(
    reduced: Reduced, steps: int, orders: tuple[Order, ...], rates: tuple[float, ...]
) -> tuple[MarchedModes, Complexes, Complexes]:
    """Marched modes, their motion and response, which every batch of points asks for too."""
    stepped = MarchedModes.of(reduced, steps)
    response = stepped.response(np.array(rates), orders)
    response.flags.writeable = False
    return stepped, stepped.periodic(np.array(rates), orders), response


@dataclass(frozen=True, eq=False)
class TorusProblem:
    """The contact problem on a grid as the core reads it, whatever the amplitudes.

    Attributes
    ----------
    contact : kernel.Contact
    rates : (modes,) ndarray
        Of the phases [rad/s].
    steps, lines : int
    orders : (orders, 2) ndarray
    told : (orders,) ndarray of bool
        Which of them the lines tell apart: modes respond to these, and the others are 0.
    """

    contact: kernel.Contact
    rates: Floats
    steps: int
    lines: int
    orders: NDArray[np.int32]
    told: Flags

    __repr__ = short_repr

    @classmethod
    def of(
        cls,
        reduced: Reduced,
        law: Friction,
        coupling: Complexes,
        reaction: Complexes,
        grid: Discretisation,
        orders: Sequence[Order],
        tolerance: float,
        held: Complexes | None = None,
        start: Complexes | None = None,
        asked: int = 0,
    ) -> Self:
        """Of arguments as `torus_harmonics` has them."""
        rates, lines = kernel.contiguous(reduced.carrier).copy(), grid.lines
        stepped = periodic = None
        told = np.ones(len(orders), dtype=bool)
        if reduced.contacts is not None:
            if rates.size == 2:
                lines, ratio = closed_lines(
                    float(rates[1] / rates[0]), lines, _OFF * tolerance, odd=not reduced.even
                )
                rates[1] = ratio * rates[0]
                told = 2 * np.abs(np.array(orders)[:, 1]) < lines
            stepped, periodic, response = _marched(
                reduced, grid.steps, tuple(orders), tuple(rates)
            )
            reaction, periodic = (
                np.where(told[:, np.newaxis, np.newaxis], values, 0.0)
                for values in (reaction - response, periodic)
            )
        contact = torus_problem(
            *(reduced, law, coupling, orders, reaction),
            *(stepped, held, start, periodic, asked),
        )
        numbers = np.ascontiguousarray(orders, np.int32)
        return cls(contact, rates, grid.steps, lines, numbers, told)

    def harmonics(
        self,
        amplitudes: ArrayLike,
        tolerance: float,
        smallest_scale: ArrayLike,
        near: Complexes | None,
    ) -> ContactHarmonics:
        """See `contact_harmonics`."""
        points, smallest = kernel.contiguous(amplitudes), kernel.contiguous(smallest_scale)
        if points.ndim != 2 or points.shape[1] != self.rates.size:
            raise SlipmodeError(f"amplitudes: must have shape (points, {self.rates.size})")
        count, contacts = len(points), self.contact.contacts
        P = np.empty((count, len(self.orders), contacts), dtype=complex)
        begun = None if near is None else np.ascontiguousarray(near)
        if begun is not None and begun.shape != P.shape:
            raise SlipmodeError(f"near: must have shape {P.shape}, got {begun.shape}")
        mean_square, residual = np.empty((count, contacts)), np.empty(count)
        marched = np.empty(count, dtype=np.int32)
        discretised = kernel.Discretisation(
            rates=self.rates.ctypes.data,
            steps=self.steps,
            lines=self.lines,
            orders_count=len(self.orders),
            orders=self.orders.ctypes.data,
            tolerance=tolerance,
            smallest_scale=smallest.ctypes.data,
            max_periods=_MAX_PERIODS,
        )
        where = kernel.TorusPoints(
            count, points.ctypes.data, None if begun is None else begun.ctypes.data
        )
        results = (each.ctypes.data for each in (P, mean_square, residual, marched))
        motion = kernel.TorusMotion(*results)
        status = kernel.lib.sm_torus_harmonics(self.contact, discretised, where, motion)
        kernel.check(status, "contact problem on the torus")
        P[:, ~self.told] = 0.0
        return ContactHarmonics(P, mean_square, residual, marched)


def contact_harmonics(
    reduced: Reduced,
    law: Friction,
    amplitudes: ArrayLike,
    grid: Discretisation,
    orders: Sequence[tuple[int, int]] = CARRIERS,
    tolerance: float = 1e-5,
    smallest_scale: ArrayLike = (0.0, 0.0),
    combinations: Sequence[CombinationResonance] = (),
    near: Complexes | None = None,
    asked: int = 0,
) -> ContactHarmonics:
    """Solve Eq. (13) for the periodic contact motion.

    Parameters
    ----------
    amplitudes : (points, modes) array_like
        Modal amplitudes |a_j| [kg^1/2 m], >= 0.
    orders : sequence of (n, m)
        Harmonics P_nm to compute. Of elastic contacts those that phase lines cannot tell apart
        from others are 0.
    tolerance : float
        The march ends when the harmonics repeat to this fraction of the frictionless contact
        displacement at the point's amplitudes.
    smallest_scale : (modes,) array_like
        Amplitudes whose frictionless displacement is the scale instead where it is larger.
    combinations : sequence of CombinationResonance
        Harmonics that a mode does not respond to here, because its slow flow does.
    near : (points, orders, N_c) complex ndarray, optional
        Of elastic contacts: harmonics that are about theirs.
    asked : int
        So many of the orders, the first, are asked for; those of sliders beyond repeat less
        well (to 3e-3 at least, where the tolerance is less), as far as modes do not respond
        to them. Default: all.

    Notes
    -----
    Marched at the carrier frequencies along t_B = t_B0 + (omega_B / omega_A) t_A with an
    L-stable second-order rule; second order in `steps`, spectral in `lines`.
    """
    problem = _steady_problem(
        reduced, law, tuple(orders), tuple(combinations), grid, float(tolerance), asked
    )
    return problem.harmonics(amplitudes, tolerance, smallest_scale, near)


@lru_cache(maxsize=8)
def _steady_problem(
    reduced: Reduced,
    law: Friction,
    orders: tuple[Order, ...],
    combinations: tuple[CombinationResonance, ...],
    grid: Discretisation,
    tolerance: float,
    asked: int,
) -> TorusProblem:
    """That of `contact_harmonics`, which every batch of points asks for too."""
    reaction = reaction_stiffnesses(reduced, orders, combinations)
    coupling = steady_coupling(reduced)
    return TorusProblem.of(reduced, law, coupling, reaction, grid, orders, tolerance, asked=asked)


def torus_harmonics(
    reduced: Reduced,
    law: Friction,
    coupling: Complexes,
    reaction: Complexes,
    amplitudes: ArrayLike,
    grid: Discretisation,
    orders: Sequence[Order],
    *,
    tolerance: float,
    smallest_scale: ArrayLike = (0.0, 0.0),
    held: Complexes | None = None,
    start: Complexes | None = None,
    near: Complexes | None = None,
) -> ContactHarmonics:
    """Contacts that carriers draw by `coupling` and modes by their `reaction` to harmonics.

    Parameters
    ----------
    coupling : (modes, N_c) complex ndarray
        -(force on the contacts) per amplitude, at each carrier.
    reaction : (orders, N_c, N_c) complex ndarray
        Force on the contacts per P_nm.
    held : (orders, N_c) complex ndarray, optional
        Force on the contacts beside. Default: none.
    start : (orders, N_c) complex ndarray, optional
        Harmonics whose reaction the search begins with; where that fails it ends. Default: none.
    near : (points, orders, N_c) complex ndarray, optional
        Of elastic contacts: harmonics it begins with instead; where that fails it goes on, as it
        does by default, when it begins with those of the point before.
    """
    problem = TorusProblem.of(
        reduced, law, coupling, reaction, grid, orders, tolerance, held, start
    )
    return problem.harmonics(amplitudes, tolerance, smallest_scale, near)
