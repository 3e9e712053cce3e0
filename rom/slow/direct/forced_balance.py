"""Contacts, modes and given forces in balance: harmonics of a steady state.

At every harmonic nu = n Omega_A + m Omega_B of the contacts all modes respond,

    D(nu) q_nm = f_nm / 2 - B(nu) P_nm,

and so do the retained modes at their carriers. Near a resonance one step of the contact problem
cannot take in that response. The amplitudes follow the slow flow, 2 i Omega da/dt + ..., by steps
of implicit Euler instead (pseudo-transient continuation, Kelley and Keyes 1998). In each step the
retained modes have the dynamic stiffness D + i kappa, with the shift kappa = 2 Omega / step.
Secants of the residual make the steps quasi-Newton steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.contact.time_budget import WorkLimit
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import Order, harmonic_orders
from slipmode.rom.reduction.reaction import strongest_resonance
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.direct.steady_harmonics import (
    Receptance,
    SteadyHarmonics,
    relative_error,
)

_FIRST_SHIFT = 0.1  # of the largest detuning of a mode by slip
# Tolerance of the contact motion far from the steady state, and at it relative to the tolerance of
# the amplitudes, by the number of modes. The phase lines of two modes drift against the grid,
# which limits the periodicity. Contacts that creep, of one mode, change little in a period long
# before they reach their steady motion.
_COARSE = {1: 1e-5, 2: 1e-3}
_PRECISION = {1: 1e-3, 2: 0.03}
LINES = (16, 32, 64, 128)
CLOSEST = 0.1  # change of the amplitudes at which the iteration ends, relative to the tolerance


@dataclass(frozen=True, eq=False, repr=False)
class Balanced(SteadyHarmonics):
    """Harmonics in balance."""

    off: Floats  # (modes,), change of the amplitudes by the next step [kg^1/2 m]
    # (4 modes, n), changes of displacements and residuals in the last steps, see `_Secants`
    changes: Floats
    grid: Discretisation


@frozen
class ForcedBalance:
    """The balance under forces 2 half cos(Omega_j t), half (modes, n) [N]."""

    reduced: Reduced
    law: Friction
    half: Floats
    tolerance: float
    work: WorkLimit

    def solve(
        self, orders: Sequence[Order], grid: Discretisation, start: SteadyHarmonics | None
    ) -> Balanced:
        """Return the steady state with these harmonics, the carriers first, on this grid."""
        receptance = Receptance.of(self.reduced, orders, self.half)
        modes, own = len(self.half), receptance.own
        B = receptance.B[own, own]
        first_shift = np.maximum(_FIRST_SHIFT * self._detuning(B), np.finfo(float).tiny)
        shift, moves = first_shift, np.linalg.norm(B, axis=1)
        target, P, secants = np.zeros(modes, dtype=complex), None, _Secants(moves)
        if start is not None:
            target, P = start.amplitude, _extended(start.P, start.orders, orders)
            same = np.array_equal(start.frequency[:modes], receptance.frequency[:modes])
            if isinstance(start, Balanced) and same:
                secants.take_on(start.changes)
        far, least, stalled = 1.0, np.inf, 0
        for _ in range(60):
            precision = np.clip(0.1 * far, _PRECISION[modes] * self.tolerance, _COARSE[modes])
            forces = self._contact_forces(receptance, shift, target, P)
            solved = self._march(orders, grid, forces, float(precision))
            # The contacts are far from periodic: the step was too long.
            if solved.residual[0] > 1e-2:
                shift, secants, P = 3.0 * shift, _Secants(moves), None
                continue
            P = solved.P[0]
            modal = receptance.modal(P, shift, target)
            found = modal[own, own]
            target = secants.next(found, 1j * shift * (found - target) / first_shift)
            if secants.spanning:
                off = np.abs(target - found) + secants.unresolved
                far = relative_error(self.reduced, off, found)
                largest = max((moves * np.abs(found)).max(), np.finfo(float).tiny)
                far = max(far, float((moves * off).max() / largest))
            stalled = 0 if far < 0.5 * least or not secants.own_suffice else stalled + 1
            least = min(far, least)
            converged = far <= CLOSEST * self.tolerance
            # Three steps without progress: the phase lines of two modes drift against the grid
            # (test_the_branch_of_two_modes_is_followed_from_a_steady_state).
            if converged or (far <= self.tolerance and stalled >= 3):
                return Balanced(
                    amplitude=found,
                    off=off,
                    changes=secants.changes,
                    orders=list(orders),
                    frequency=receptance.frequency,
                    modal=modal,
                    P=P,
                    grid=grid,
                )
        raise self._refusal(orders, solved)

    def responding(self, state: Balanced, highest: int) -> tuple[list[Order], Floats]:
        """Return more harmonics up to an order to which modes respond, and the effect of others.

        The effect is the sum of the forces that the others would exert on the contacts, as
        amplitudes (modes,) that would exert the same [kg^1/2 m].
        """
        modes, known = len(self.half), len(state.orders)
        candidates = harmonic_orders(highest, modes, self.reduced.even)
        more = [order for order in candidates if order not in state.orders]
        orders = [*state.orders, *more]
        receptance = Receptance.of(self.reduced, orders, self.half)
        P = _extended(state.P, state.orders, orders)
        shift = _FIRST_SHIFT * self._detuning(receptance.B[receptance.own, receptance.own])
        forces = self._contact_forces(receptance, shift, state.amplitude, P)
        reaction = forces.reaction.copy()
        forces.reaction[known:] = 0.0
        grid = replace(state.grid, lines=enough_lines(orders, state.grid.lines))
        solved = self._march(orders, grid, forces, _COARSE[modes])
        moved = np.abs(np.einsum("qcd,qd->qc", reaction, solved.P[0])).max(axis=1)[known:]
        carried = np.einsum("qkc,qk->qc", receptance.B[:modes], state.modal[:modes])
        # Smaller responses are negligible.
        wanted = moved > 0.03 * self.tolerance * np.abs(carried).max()
        moves = np.linalg.norm(self.reduced.coupling, axis=1)
        neglected = moved[~wanted].sum() / np.maximum(moves, np.finfo(float).tiny)
        return [order for order, one in zip(more, wanted, strict=True) if one], neglected

    def _detuning(self, B: Complexes) -> Floats:
        """Return the largest change of omega_j^2 by slip, (modes,), of modes with coupling B."""
        if self.reduced.contacts is not None:
            return np.asarray(np.abs(B) ** 2 @ self.reduced.contacts.reference)
        moved = np.linalg.solve(self.reduced.stiffness, B.conj().T)
        return np.asarray(np.abs(np.einsum("jc,cj->j", B, moved)))

    def _contact_forces(
        self, receptance: Receptance, shift: Floats, target: Complexes, guess: Complexes | None
    ) -> ContactForces:
        """Return the forces on the contacts in a step: stuck modes and reactions.

        A step is (D + i kappa) q = f / 2 - B P + i kappa q_0, with `shift` kappa, `target` q_0.
        """
        modes = len(self.half)
        still = np.zeros((len(receptance.orders), self.reduced.n_contacts), dtype=complex)
        stuck = receptance.modal(still, shift, target)
        held = -np.einsum("qkc,qk->qc", receptance.B, stuck)
        held[:modes] += self.half @ self.reduced.contact_shapes
        coupling = -held[:modes]
        held[:modes] = 0.0
        return ContactForces(coupling, receptance.reaction(shift), held, guess)

    def _march(
        self,
        orders: Sequence[Order],
        grid: Discretisation,
        forces: ContactForces,
        tolerance: float,
    ) -> ContactTerms:
        problem = ContactProblem(
            self.reduced, self.law, tuple(orders), given_forces=forces, work=self.work
        )
        return problem.on(grid, tolerance).solve(np.ones((1, len(self.half))))

    def _refusal(self, orders: Sequence[Order], solved: ContactTerms) -> SlipmodeError:
        met = strongest_resonance(self.reduced, orders)
        n, m = met.order
        return SlipmodeError(
            "frequency: no steady state was found. The residual is "
            f"{percentage(solved.residual[0])}. The mode at {met.mode:.4g} rad/s responds most, "
            f"to harmonic ({n}, {m}) at {met.harmonic:.4g} rad/s, so the motion may not be "
            "periodic; move the forcing, give damping to that mode, or integrate in time "
            "(rom.full)"
        )


def enough_lines(orders: Sequence[Order], least: int = 1) -> int:
    """Return a number of phase lines that distinguishes these harmonics."""
    highest = max(abs(m) for _, m in orders)
    if highest == 0:
        return 1
    return max(least, next((n for n in LINES if n > 2 * highest), LINES[-1]))


class _Secants:
    """The displacement at which the residual would be 0, by its last changes (Anderson 1965).

    Attributes
    ----------
    unresolved : (modes,) ndarray
        Displacement by the part of the residual that no change has touched, if the structure
        were as soft to it as to the change to which it was softest.
    """

    def __init__(self, moves: Floats) -> None:
        """Displacements are weighted by the contact forces `moves` (modes,) that they cause."""
        self._moves = np.maximum(moves, 1e-300)
        # The changes of one mode span its plane at once: a later residual is noise of friction.
        self._enough = {1: 1, 2: 4}[moves.size]
        self.unresolved = np.zeros(moves.size)
        self._points: list[Floats] = []
        self._before = np.zeros((4 * moves.size, 0))

    def take_on(self, changes: Floats) -> None:
        """Use the changes of another balance of the same two modes at the same frequencies.

        A balance of one mode finds its own in two steps.
        """
        if self._enough > 1:
            self._before = changes

    @property
    def changes(self) -> Floats:
        """Weighted changes of displacements, and below of the residual, (4 modes, n).

        The last are first. Changes of another balance are used until there are enough own ones,
        because they differ by the error of its grid.
        """
        last, *before = reversed(self._points)
        own = np.array([last - point for point in before]).reshape(-1, last.size).T
        if self.own_suffice:
            return own
        return np.hstack((own, self._before))[:, : 2 * self._moves.size]

    @property
    def own_suffice(self) -> bool:
        """Whether there are enough changes without the changes of another balance."""
        return len(self._points) > self._enough

    @property
    def spanning(self) -> bool:
        """Whether there are enough changes for all motions of the retained modes."""
        return bool(self.changes.shape[1] >= self._enough)

    def next(self, found: Complexes, residual: Complexes) -> Complexes:
        """Return the next displacement (modes,)."""
        moved = self._moves * np.array((found, residual))
        self._points = [*self._points[-2 * found.size :], moved.ravel().view(float)]
        changes = self.changes
        if not changes.size:
            return found
        last, size = self._points[-1], 2 * found.size
        theta = np.linalg.lstsq(changes[size:], last[size:], rcond=1e-6)[0]
        displaced, unbalanced = (np.linalg.norm(c, axis=0) for c in np.split(changes, [size]))
        softest = (displaced / np.maximum(unbalanced, 1e-300)).max()
        rest = (last[size:] - changes[size:] @ theta).view(complex)
        if self._enough > 1:
            self.unresolved = softest * np.abs(rest) / self._moves
        move = (changes[:size] @ theta).view(complex)
        return np.asarray(found - move / self._moves)


def _extended(known: Complexes, orders: Sequence[Order], wanted: Sequence[Order]) -> Complexes:
    """Return rows of some harmonics for others, 0 for new ones."""
    rows = dict(zip(orders, known, strict=True))
    return np.array([rows.get(order, np.zeros_like(known[0])) for order in wanted])
