"""Contacts, modes and given forces in balance: harmonics of a steady state.

At every harmonic nu = n Omega_A + m Omega_B of the contacts all modes respond,

    D(nu) q_nm = f_nm / 2 - B(nu) P_nm,

the retained ones to their carriers as well. Near a resonance that is more than the contact problem
can take in one step; the amplitudes are led there along the slow flow, 2 i Omega da/dt + ..., by
steps of implicit Euler (pseudo-transient continuation, Kelley and Keyes 1998): in each of them the
retained mode has the dynamic stiffness D + i kappa, kappa = 2 Omega / step, and drags what it was.
Secants of the imbalance in these steps make them quasi-Newton's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import Order, harmonic_orders
from slipmode.rom.reduction.reaction import strongest_resonance
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.direct.receptance import Receptance
from slipmode.rom.slow.direct.steady_harmonics import SteadyHarmonics, relative_error

_UNSETTLED = 1e-2  # distance from periodicity from where a step was too long
_STEPS = 60
_SHORTEST_STEP = 1e4  # kappa, over the first: nothing moves any more
# Of the contacts' motion, by modes: far from the steady state, and at it by the tolerance. With
# two the phases of the lines drift against the grid; that is only as small as its error. With one
# contacts that creep change little in a period long before they are where they tend to.
_COARSE = {1: 1e-5, 2: 1e-3}
_PRECISION = {1: 1e-3, 2: 0.03}
_PATIENCE = 3
_MOST_SECANTS = 12
_LONGEST_MOVE = 0.5  # by secants, of the largest displacement
_SMALL = 0.03  # response to a harmonic that does not count, of the tolerance
_ONE_CONTACT = 20  # harmonics that cost as much as what else a contact takes in a step
LINES = (16, 32, 64, 128)
CLOSEST = 0.1  # of the tolerance: change of the amplitudes at which the iteration ends


@dataclass(frozen=True, eq=False)
class Balanced(SteadyHarmonics):
    """Those of a balance.

    Attributes
    ----------
    off : (modes,) ndarray
        By what the next step would change the amplitudes [kg^1/2 m].
    changes : (8 or more, n) ndarray
        Of displacements and of the imbalance on the way, see `_Secants`.
    grid : Discretisation
    """

    off: Floats
    changes: Floats
    grid: Discretisation

    __repr__ = short_repr


class Effort:
    """Steps along phase lines that a balance may still march, weighted by what one costs."""

    def __init__(self, most: float) -> None:
        """Of N_c (N_c + orders + ...) each."""
        self.left = most

    def spend(self, steps: float, contacts: int, orders: int) -> None:
        """So many steps of so many contacts and harmonics."""
        self.left -= steps * contacts * (contacts + orders + _ONE_CONTACT)
        if self.left < 0.0:
            raise SlipmodeError(
                "frequency: no steady state found, the search takes longer than integration in "
                "time would (rom.full)"
            )


@dataclass(frozen=True, eq=False)
class ForcedBalance:
    """The balance under forces 2 half cos(Omega_j t), (modes, n).

    Attributes
    ----------
    effort : Effort
        That it may take.
    led : float
        Dynamic stiffness below which steps lead a mode at a harmonic too, over that of the first
        step; 0: the retained modes alone are led.
    first_step : float
        kappa of that, over how far slip can detune the mode.
    """

    reduced: Reduced
    law: Friction
    half: Floats
    tolerance: float
    effort: Effort
    led: float
    first_step: float

    __repr__ = short_repr

    def _receptance(self, orders: Sequence[Order]) -> Receptance:
        return Receptance.of(self.reduced, orders, self.half, self.led, self.first_step)

    def solve(
        self, orders: Sequence[Order], grid: Discretisation, start: SteadyHarmonics | None
    ) -> Balanced:
        """The steady state with these harmonics, the carriers first, on this grid."""
        modes = len(self.half)
        receptance = self._receptance(orders)
        q, k = receptance.resonant
        frequency = receptance.frequency[:modes]
        target, P = np.zeros(q.size, dtype=complex), None
        if start is not None:
            P = _extended(start.P, start.orders, orders)
            target = _extended(start.modal, start.orders, orders)[q, k]
        kappa, moves = receptance.kappa, np.linalg.norm(receptance.B[q, k], axis=1)
        secants = _Secants(moves, modes)
        if isinstance(start, Balanced) and np.array_equal(start.frequency[:modes], frequency):
            secants.take_on(start.changes)
        closest, far, least, idle = CLOSEST * self.tolerance, 1.0, np.inf, 0
        finest = _PRECISION[modes] * self.tolerance
        for _ in range(_STEPS):
            precision = float(np.clip(0.1 * far, finest, _COARSE[modes]))
            reaction = receptance.stepped_reaction(kappa)
            solved = self._contacts(
                receptance, reaction, orders, grid, kappa, target, P, precision
            )
            if solved.residual[0] > _UNSETTLED:
                kappa, secants, P = 3.0 * kappa, _Secants(moves, modes), None
                if kappa[0] > _SHORTEST_STEP * receptance.kappa[0]:
                    break
                continue
            P = solved.P[0]
            modal = receptance.stepped_modal(P, kappa, target)
            found = modal[q, k]
            imbalance = 1j * kappa * (found - target) / receptance.kappa
            target = secants.next(found, imbalance)
            if secants.spanning:
                off = np.abs(target - found) + secants.unresolved
                far = relative_error(self.reduced, off[:modes], found[:modes])
                drawn = max((moves * np.abs(found))[:modes].max(), np.finfo(float).tiny)
                far = max(far, float((moves * off).max() / drawn))
            idle = 0 if far < 0.5 * least or not secants.own_suffice else idle + 1
            least = min(far, least)
            if far <= closest or (far <= self.tolerance and idle >= _PATIENCE):
                return Balanced(
                    amplitude=found[:modes],
                    off=off[:modes],
                    changes=secants.changes,
                    orders=list(orders),
                    frequency=receptance.frequency,
                    modal=modal,
                    P=P,
                    grid=grid,
                )
        raise self._refusal(orders, solved)

    def responding(self, state: Balanced, highest: int) -> tuple[list[Order], Floats]:
        """Further harmonics up to an order that modes respond to, and what others amount to.

        That is the sum of what these would do to the contacts, as amplitudes (modes,) that would
        do the same [kg^1/2 m].
        """
        modes, known = len(self.half), len(state.orders)
        candidates = harmonic_orders(highest, modes, self.reduced.even)
        further = [order for order in candidates if order not in state.orders]
        orders = [*state.orders, *further]
        receptance = self._receptance(orders)
        q, k = receptance.resonant
        reaction = receptance.stepped_reaction(receptance.kappa)
        reaction[known:] = 0.0
        target = _extended(state.modal, state.orders, orders)[q, k]
        solved = self._contacts(
            receptance,
            reaction,
            orders,
            replace(state.grid, lines=enough_lines(orders, state.grid.lines)),
            receptance.kappa,
            target,
            _extended(state.P, state.orders, orders),
            _COARSE[modes],
        )
        moved = np.abs(np.einsum("qcd,qd->qc", receptance.reaction, solved.P[0])).max(axis=1)
        carried = np.einsum("qkc,qk->qc", receptance.B[:modes], state.modal[:modes])
        wanted = moved[known:] > _SMALL * self.tolerance * np.abs(carried).max()
        moves = np.linalg.norm(self.reduced.coupling, axis=1)
        left = moved[known:][~wanted].sum() / np.maximum(moves, np.finfo(float).tiny)
        return [order for order, one in zip(further, wanted, strict=True) if one], left

    def _contacts(
        self,
        receptance: Receptance,
        reaction: Complexes,
        orders: Sequence[Order],
        grid: Discretisation,
        kappa: Floats,
        target: Complexes,
        start: Complexes | None,
        tolerance: float,
    ) -> ContactTerms:
        """The contacts in a step, (D + i kappa) q = f / 2 - B P + i kappa target."""
        modes = len(self.half)
        nothing = np.zeros((len(orders), self.reduced.n_contacts), dtype=complex)
        stuck = receptance.stepped_modal(nothing, kappa, target)
        held = -np.einsum("qkc,qk->qc", receptance.B, stuck)
        held[:modes] += self.half @ self.reduced.contact_shapes
        coupling = -held[:modes]
        held[:modes] = 0.0
        forces = ContactForces(coupling, reaction, held, start)
        problem = ContactProblem(self.reduced, self.law, tuple(orders), given_forces=forces)
        solved = problem.on(grid, tolerance).solve(np.ones((1, modes)))
        marched = float(solved.marched[0]) * grid.lines
        self.effort.spend(marched, self.reduced.n_contacts, len(orders))
        return solved

    def _refusal(self, orders: Sequence[Order], solved: ContactTerms) -> SlipmodeError:
        met = strongest_resonance(self.reduced, orders)
        n, m = met.order
        return SlipmodeError(
            f"frequency: no steady state found, the last try was off by {solved.residual[0]:.1g}; "
            f"the modes' response is the largest in that at {met.mode:.4g} rad/s to harmonic "
            f"({n}, {m}) at {met.harmonic:.4g} rad/s: the motion may not be periodic there; move "
            "the forcing, give damping to that mode, or integrate in time (rom.full)"
        )


def enough_lines(orders: Sequence[Order], least: int = 1) -> int:
    """Phase lines that tell these harmonics apart."""
    highest = max(abs(m) for _, m in orders)
    if highest == 0:
        return 1
    return max(least, next((n for n in LINES if n > 2 * highest), LINES[-1]))


class _Secants:
    """Where the imbalance would be 0, by its last changes (Anderson 1965).

    Attributes
    ----------
    unresolved : (pairs,) ndarray
        Displacement by the part of the imbalance that no change has touched, were the structure as
        soft to that as to the one change that it was softest to.
    """

    def __init__(self, moves: Floats, modes: int) -> None:
        """Weighted by what unit displacements (pairs,), `modes` retained, do to the contacts."""
        self._moves = moves
        # of one mode the first tells enough, and friction's noise would pass for what is left
        self._enough = {1: 1, 2: 4}[modes]
        self.unresolved = np.zeros(moves.size)
        self._most = min(2 * moves.size, _MOST_SECANTS)
        self._points: list[Floats] = []
        self._before = np.zeros((4 * moves.size, 0))

    def take_on(self, changes: Floats) -> None:
        """Those of another balance of the same modes at the same frequencies.

        Of one mode a balance finds its own in two steps.
        """
        if self._enough > 1 and len(changes) == len(self._before):
            self._before = changes

    @property
    def changes(self) -> Floats:
        """Of displacements, and of the imbalance below, weighted, (4 pairs, n); the last first.

        Its own where they are enough: those of another grid differ by what it moves.
        """
        last, *before = reversed(self._points)
        own = np.array([last - point for point in before]).reshape(-1, last.size).T
        if self.own_suffice:
            return own
        return np.hstack((own, self._before))[:, : self._most]

    @property
    def own_suffice(self) -> bool:
        """Whether there are enough without those taken on."""
        return len(self._points) > self._enough

    @property
    def spanning(self) -> bool:
        """Whether there are enough for all the retained modes may do."""
        return bool(self.changes.shape[1] >= self._enough)

    def next(self, found: Complexes, imbalance: Complexes) -> Complexes:
        """The next displacement (pairs,)."""
        moved = self._moves * np.array((found, imbalance))
        self._points = [*self._points[-self._most :], moved.ravel().view(float)]
        changes = self.changes
        if not changes.size:
            return found
        last, size = self._points[-1], 2 * found.size
        theta = np.linalg.lstsq(changes[size:], last[size:], rcond=1e-6)[0]
        displaced, unbalanced = (np.linalg.norm(c, axis=0) for c in np.split(changes, [size]))
        softest = (displaced / np.maximum(unbalanced, 1e-300)).max()
        left = (last[size:] - changes[size:] @ theta).view(complex)
        if self._enough > 1:
            self.unresolved = softest * np.abs(left) / np.maximum(self._moves, 1e-300)
        move = (changes[:size] @ theta).view(complex)
        most = _LONGEST_MOVE * np.abs(moved[0]).max()
        part = min(1.0, most / max(np.abs(move).max(), 1e-300))
        return np.asarray(found - part * move / np.maximum(self._moves, 1e-300))


def _extended(known: Complexes, orders: Sequence[Order], wanted: Sequence[Order]) -> Complexes:
    """Rows of some harmonics for others, 0 where there are none."""
    rows = dict(zip(orders, known, strict=True))
    return np.array([rows.get(order, np.zeros_like(known[0])) for order in wanted])
