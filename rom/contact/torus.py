"""The contact problem on the torus, Eqs. (13), (14), (20), by characteristics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.harmonics import left_out
from slipmode.rom.contact.marched_modes import MarchedModes
from slipmode.rom.contact.problem import torus_problem
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import (
    CARRIERS,
    CombinationResonance,
    Order,
    harmonic_orders,
)
from slipmode.rom.reduction.force_response import steady_coupling, steady_reaction
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.short_repr import short_repr

_MAX_PERIODS = 400
_LEAST_STEPS_PER_PERIOD = 4  # of either mode, on the coarsest grid
_MOST_STEPS = 2048
_HALF = 0.6  # of the work: that half periods take, of whole ones
_OFF = 3.0  # of the tolerance of marches: the ratio, which moves S by about a third of that


@dataclass(frozen=True)
class Discretisation:
    """How finely the torus is resolved.

    Attributes
    ----------
    steps : int
        Time steps per period of mode A.
    lines : int
        Phase lines of mode B, a power of two; 1 for a one-mode model. Of elastic contacts the
        least number, see `closed_lines`.
    """

    steps: int
    lines: int


@lru_cache(maxsize=64)
def closed_lines(ratio: float, least: int, off: float, *, odd: bool) -> tuple[int, float]:
    """Phase lines that go over into each other in a period of mode A, and Omega_B / Omega_A then.

    Lines that drift against the grid leave harmonics moving by its error, and a search for the
    periodic motion cannot come nearer than that. With a multiple of 1 / lines for a ratio a
    period takes each line to where another one was. Of up to twice the least the fewest lines are
    taken whose multiple is off by no more than `off`, relatively, or else those of the closest.

    Where the motion is `odd`, half a period does so with both phases turned by pi, if lines and
    multiple are both odd or both even: other lines are taken for that if it is less work, and
    they are about as close.
    """
    counts = range(least, 2 * least + 1)

    def closest(multiples: dict[int, int]) -> tuple[int, float]:
        away = {count: abs(multiples[count] / count / ratio - 1.0) for count in counts}
        near = [count for count in counts if away[count] <= off]
        lines = near[0] if near else min(counts, key=away.__getitem__)
        return lines, multiples[lines] / lines

    whole = closest({count: round(ratio * count) for count in counts})
    if not odd:
        return whole
    half = closest({count: 2 * round(0.5 * (ratio - 1.0) * count) + count for count in counts})
    away = abs(half[1] / ratio - 1.0)
    close = away <= max(off, 2.0 * abs(whole[1] / ratio - 1.0))
    return half if close and _HALF * half[0] <= whole[0] else whole


def step_counts(carrier: Floats, least: int) -> tuple[int, ...]:
    """Time steps per period of mode A to try, from `least`, each twice the one before.

    The first sees several in a period of mode B too: with fewer, slip would follow another path
    than the one along a phase line, and as steadily on twice as many.
    """
    fewest = _LEAST_STEPS_PER_PERIOD * max(float(carrier.max() / carrier[0]), 1.0)
    while least < fewest:
        least *= 2
    most = max(_MOST_STEPS, 16 * least)
    return tuple(least << k for k in range((most // least).bit_length()))


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
    """

    contact: kernel.Contact
    rates: Floats
    steps: int
    lines: int
    orders: NDArray[np.int32]

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
        near: Complexes | None = None,
    ) -> Self:
        """Of arguments as `torus_harmonics` has them."""
        rates, lines = kernel.contiguous(reduced.carrier).copy(), grid.lines
        stepped = periodic = None
        if reduced.contacts is not None:
            if rates.size == 2:
                lines, ratio = closed_lines(
                    float(rates[1] / rates[0]), lines, _OFF * tolerance, odd=not reduced.even
                )
                rates[1] = ratio * rates[0]
            stepped, periodic, response = _marched(
                reduced, grid.steps, tuple(orders), tuple(rates)
            )
            reaction = reaction - response
        contact = torus_problem(
            *(reduced, law, coupling, orders, np.ascontiguousarray(reaction), stepped),
            None if held is None else np.ascontiguousarray(held),
            None if start is None else np.ascontiguousarray(start),
            None if near is None else np.ascontiguousarray(near),
            periodic,
        )
        return cls(contact, rates, grid.steps, lines, np.ascontiguousarray(orders, np.int32))

    def harmonics(
        self, amplitudes: ArrayLike, tolerance: float, smallest_scale: ArrayLike
    ) -> ContactHarmonics:
        """See `contact_harmonics`."""
        points, smallest = kernel.contiguous(amplitudes), kernel.contiguous(smallest_scale)
        if points.ndim != 2 or points.shape[1] != self.rates.size:
            raise SlipmodeError(f"amplitudes: must have shape (points, {self.rates.size})")
        count, contacts = len(points), self.contact.contacts
        P = np.empty((count, len(self.orders), contacts), dtype=complex)
        mean_square, residual = np.empty((count, contacts)), np.empty(count)
        marched = np.empty(count, dtype=np.int32)
        status = kernel.lib.sm_torus_harmonics(
            *(self.contact, self.rates.ctypes.data, self.steps, self.lines, tolerance),
            *(smallest.ctypes.data, _MAX_PERIODS, count, points.ctypes.data),
            *(len(self.orders), self.orders.ctypes.data, P.ctypes.data),
            *(mean_square.ctypes.data, residual.ctypes.data, marched.ctypes.data),
        )
        kernel.check(status, "contact problem on the torus")
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
) -> ContactHarmonics:
    """Solve Eq. (13) for the periodic contact motion.

    Parameters
    ----------
    amplitudes : (points, modes) array_like
        Modal amplitudes |a_j| [kg^1/2 m], >= 0.
    orders : sequence of (n, m)
        Harmonics P_nm to compute.
    tolerance : float
        The march ends when the harmonics repeat to this fraction of the frictionless contact
        displacement at the point's amplitudes.
    smallest_scale : (modes,) array_like
        Amplitudes whose frictionless displacement is the scale instead where it is larger.
    combinations : sequence of CombinationResonance
        Harmonics that a mode does not respond to here, because its slow flow does.
    near : (points, orders, N_c) complex ndarray, optional
        Of elastic contacts: harmonics that are about theirs.

    Notes
    -----
    Marched at the carrier frequencies along t_B = t_B0 + (omega_B / omega_A) t_A with an
    L-stable second-order rule; second order in `steps`, spectral in `lines`.
    """
    if near is None:
        problem = _steady_problem(
            reduced, law, tuple(orders), tuple(combinations), grid, float(tolerance)
        )
        return problem.harmonics(amplitudes, tolerance, smallest_scale)
    reaction = reaction_stiffnesses(reduced, tuple(orders), tuple(combinations))
    return torus_harmonics(
        *(reduced, law, steady_coupling(reduced), reaction, amplitudes, grid, orders),
        tolerance=tolerance,
        smallest_scale=smallest_scale,
        near=near,
    )


@lru_cache(maxsize=8)
def _steady_problem(
    reduced: Reduced,
    law: Friction,
    orders: tuple[Order, ...],
    combinations: tuple[CombinationResonance, ...],
    grid: Discretisation,
    tolerance: float,
) -> TorusProblem:
    """That of `contact_harmonics`, which every batch of points asks for too."""
    reaction = reaction_stiffnesses(reduced, orders, combinations)
    coupling = steady_coupling(reduced)
    return TorusProblem.of(reduced, law, coupling, reaction, grid, orders, tolerance)


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
        reduced, law, coupling, reaction, grid, orders, tolerance, held, start, near
    )
    return problem.harmonics(amplitudes, tolerance, smallest_scale)


@dataclass(frozen=True, eq=False)
class ContactTerms:
    """What the contacts do to the modes at several amplitudes.

    Attributes
    ----------
    S : (points, modes) complex ndarray
        Q_j |a_j| of Eq. (20), and what comes back through dampers to other modes [N kg^-1/2];
        exactly 0 where |a_j| = 0.
    T : (points, combinations) complex ndarray
        -L_j^T P_nm of the combination resonances.
    orders : list of (n, m)
        Harmonics in P.
    P : (points, orders, N_c) complex ndarray
        Of the contact displacement [m].
    left_out : (points, N_c) ndarray
        RMS of the contact displacement beyond these harmonics [m].
    power : (points,) ndarray
        Mean power that friction dissipates [W].
    leaving : (points,) ndarray
        Mean power that leaves the modes at the contacts [W]; dampers share it with friction.
    residual : (points,) ndarray
        Distance from periodicity.
    marched : (points,) ndarray of int
        Time steps marched along each phase line.
    """

    S: Complexes
    T: Complexes
    power: Floats
    leaving: Floats
    orders: list[Order]
    P: Complexes
    left_out: Floats
    residual: Floats
    marched: NDArray[np.int32]

    __repr__ = short_repr


def contact_orders(
    reduced: Reduced,
    combinations: Sequence[CombinationResonance] = (),
    highest: int = 1,
    further: Sequence[Order] = (),
) -> list[Order]:
    """Harmonics up to an order, those that modes and combination resonances need, and others."""
    if reduced.formulation == "consistent":
        highest = max(highest, RESPONSE_ORDER)
    orders = harmonic_orders(highest, len(reduced.modes), reduced.even)
    resonant = (term.stored_order for term in combinations)
    return list(dict.fromkeys([*orders, *resonant, *further]))


def contact_terms(
    reduced: Reduced,
    law: Friction,
    amplitudes: ArrayLike,
    grid: Discretisation,
    tolerance: float = 1e-5,
    smallest_scale: ArrayLike = (0.0, 0.0),
    combinations: Sequence[CombinationResonance] = (),
    highest: int = 1,
    further: Sequence[Order] = (),
    near: Complexes | None = None,
) -> ContactTerms:
    """Solve the contact problem and project its harmonics on the modes; see contact_harmonics.

    `highest` is the order up to which harmonics are wanted, `further` are others: see
    contact_orders.
    """
    orders = contact_orders(reduced, combinations, highest, further)
    solved = contact_harmonics(
        *(reduced, law, amplitudes, grid, orders, tolerance, smallest_scale, combinations),
        near,
    )
    a, P = kernel.contiguous(amplitudes), solved.P
    projection = _projection(reduced, tuple(orders), tuple(combinations))
    S = np.where(a == 0.0, 0.0, projection.forces(P) - reduced.indirect_damping * a)
    leaving = -2.0 * (a * S.imag) @ reduced.carrier
    return ContactTerms(
        *(S, projection.combined(P), projection.friction_power(a, P), leaving, orders, P),
        *(left_out(orders, P, solved.mean_square), solved.residual, solved.marched),
    )


@dataclass(frozen=True, eq=False)
class _Projection:
    """How harmonics P (points, orders, N_c) of the contacts act on the modes, and what they lose.

    Attributes
    ----------
    coupling : (modes, N_c) ndarray
        L_j.
    drawn : (modes, N_c) ndarray
        2 conj(i nu_j) L_j of modes that their forces hold steady: their work on the carriers.
    lost : (orders, N_c, N_c) ndarray
        2 conj(i nu) times the force of the modes' response on the contacts per P_nm, less what
        the contacts' own damping takes.
    stored : (combinations,) ndarray of int
        Where in P the harmonics of combination resonances are.
    flipped : (combinations,) ndarray of bool
        Whether these are their conjugates.
    combining : (combinations, N_c) ndarray
        L_j of the modes that they drive.
    """

    coupling: Complexes
    drawn: Complexes
    lost: Complexes
    stored: NDArray[np.intp]
    flipped: Flags
    combining: Complexes

    __repr__ = short_repr

    def forces(self, P: Complexes) -> Complexes:
        """-L_j^T P_j (points, modes)."""
        return np.asarray(-np.einsum("jc,pjc->pj", self.coupling, P[:, : len(self.coupling)]))

    def combined(self, P: Complexes) -> Complexes:
        """-L_j^T P_nm of the combination resonances, (points, combinations)."""
        if not self.stored.size:
            return np.zeros((len(P), 0), dtype=complex)
        driving = P[:, self.stored]
        driving = np.where(self.flipped[:, np.newaxis], driving.conj(), driving)
        return np.asarray(-np.einsum("kc,pkc->pk", self.combining, driving))

    def friction_power(self, amplitudes: Floats, P: Complexes) -> Floats:
        """Work of the forces on the contacts, less what their own damping takes; (points,).

        A force 2 Re(F exp(i nu t)) works on a displacement 2 Re(P exp(i nu t)) at the mean rate
        2 Re(F conj(i nu P)).
        """
        work = np.einsum("pqc,qcd->pqd", P, self.lost)
        work[:, : len(self.drawn)] -= amplitudes[..., np.newaxis] * self.drawn
        return np.asarray(np.maximum(np.einsum("pqc,pqc->p", work, P.conj()).real, 0.0))


@lru_cache(maxsize=8)
def _projection(
    reduced: Reduced, orders: tuple[Order, ...], combinations: tuple[CombinationResonance, ...]
) -> _Projection:
    """That of a steady state, which every batch of points asks for too."""
    modes = len(reduced.modes)
    backwards = -2j * (np.array(orders)[:, :modes] @ reduced.carrier)
    force = reaction_stiffnesses(reduced, orders, combinations)
    if reduced.contacts is None:
        force = force + 0.5 * backwards[:, np.newaxis, np.newaxis] * reduced.damping
    return _Projection(
        reduced.coupling,
        backwards[:modes, np.newaxis] * steady_coupling(reduced),
        backwards[:, np.newaxis, np.newaxis] * force,
        np.array([orders.index(term.stored_order) for term in combinations], dtype=int),
        np.array([term.stored_order != (term.n, term.m) for term in combinations], dtype=bool),
        reduced.coupling[[term.mode for term in combinations]],
    )


def friction_functions(
    reduced: Reduced,
    law: Friction,
    amplitudes: ArrayLike,
    grid: Discretisation,
    tolerance: float = 1e-5,
) -> Complexes:
    """The complex friction functions Q_j of Eq. (20), (points, modes), for amplitudes > 0."""
    S = contact_terms(reduced, law, amplitudes, grid, tolerance).S
    Q: Complexes = S / np.asarray(amplitudes, dtype=float)
    return Q
