"""Contacts, modes and given forces in balance: harmonics of a steady state.

At every harmonic nu = n Omega_A + m Omega_B all modes respond to the contacts,

    D(nu) q_nm = f_nm / 2 - B(nu) P_nm.

F(P) are the harmonics of contacts that move under this response, by a march over a few periods. A
steady state is P = F(P), solved by Newton's method with GMRES; directional derivatives are
differences of F (Knoll and Keyes 2004). From rest, the modes follow their slow flow

    2 i nu dq/dt + D q = f / 2 - B P

by steps of implicit Euler that become longer (pseudo-transient continuation, Kelley and Keyes
1998). It leads to the branch that a slow transient reaches.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.interaction.mode_proposals import resonance_words
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.direct.steady_harmonics import (
    Receptance,
    SteadyHarmonics,
    SteadyProblem,
    relative_error,
)

CLOSEST = 0.05  # change of the amplitudes by the last Newton step, relative to the tolerance
# The march tolerance, relative to the tolerance of the amplitudes; and differences of F, relative
# to the contact motion, which are far larger.
_MARCH_TOLERANCE, _DIFFERENCE = 1e-4, 1e-5
_ROUNDING = 1e-4  # residual relative to the tolerance that marches leave
_LEAST_FORCE = 0.01  # of the forces on the modes: weaker contact forces need no precision
_MOST_DIRECTIONS = 40  # of GMRES
_PARTS = 1.0, 0.4, 0.16  # of a Newton step in the line search
_FINAL_STEPS = 12  # of Newton's method at the steady state
# A time step of the slow flow is one Newton step. The next one is longer if that reduces the
# residual to this part, else shorter.
_CONVERGING, _LONGER, _SHORTER = 0.4, 2.0, 0.2
_NEARLY_STEADY = 0.05  # change in a time step after which the steady state is tried
# Of 98 drawn structures 97 need at most 43; what takes more is integrated in time.
_MOST_TIME_STEPS = 50


@dataclass(frozen=True, eq=False)
class _Iterate:
    """Contact harmonics P (orders, N_c), their image F(P), and the modes that it follows from."""

    P: Complexes
    F: Complexes
    modal: Complexes  # (orders, modes + nonresonant)


@frozen
class ForcedBalance:
    """The balance of contacts, modes and forces at some harmonics, on one grid."""

    problem: SteadyProblem
    orders: tuple[Order, ...]  # harmonics of the contacts, the carriers first
    grid: Discretisation

    def solve(self, start: SteadyHarmonics | None) -> SteadyHarmonics:
        """Return the steady state near `start`, or the state that is reached from rest.

        Raises
        ------
        SlipmodeError
            If the iteration does not converge.
        """
        P = np.zeros((len(self.orders), self.problem.reduced.n_contacts), dtype=complex)
        modal = np.zeros_like(self.receptance.loads)
        if start is not None:
            P = start.at(self.orders)
            modal = self.receptance.modal(P)
            found = self._steady(P)
            if found is not None:
                return found
        return self._after_transient(P, modal)

    def checked(self, found: SteadyHarmonics) -> tuple[float, SteadyHarmonics]:
        """Put a steady state with fewer harmonics, on a coarser grid, into these equations.

        Returns the largest unbalanced force on a mode near one of its harmonics, relative to the
        forces, and the state with all harmonics.
        """
        state, known = self._steady_step.iterate(found.at(self.orders)), len(found.orders)
        off = np.einsum("qkc,qc->qk", self.receptance.B, state.F - state.P)[:known]
        off = np.where(self.receptance.resonant[:known], off, 0.0)
        more = np.vstack((found.P, state.F[known:]))
        modal = self.receptance.modal(more)
        modal[:known] = found.modal
        nu = self.receptance.frequency
        largest = np.abs(self.receptance.loads).max()
        full = SteadyHarmonics(found.amplitude, list(self.orders), nu, modal, more)
        return float(np.abs(off).max() / largest), full

    @cached_property
    def receptance(self) -> Receptance:
        """Matrices of the modes at the harmonics."""
        return Receptance.of(self.problem.reduced, self.orders, 0.5 * self.problem.force)

    @cached_property
    def _steady_step(self) -> _TimeStep:
        return _TimeStep(self, np.inf, np.zeros_like(self.receptance.loads))

    def contact_motion(self, forces: Complexes, guess: Complexes) -> Complexes:
        """Return the harmonics of contacts under forces (orders, N_c) [N], from a guess P."""
        problem, modes = self.problem, len(self.problem.force)
        coupling, constant = -forces[:modes], forces.copy()
        constant[:modes] = 0.0
        given = ContactForces(coupling, np.empty(0, dtype=complex), constant, guess)
        contacts = ContactProblem(
            problem.reduced, problem.law, self.orders, given_forces=given, work=problem.work
        )
        torus = contacts.on(self.grid, _MARCH_TOLERANCE * problem.tolerance)
        found: Complexes = torus.solve(np.ones((1, modes))).P[0]
        return found

    def _steady(self, P: Complexes) -> SteadyHarmonics | None:
        """Return the steady state by Newton's method, None if it does not converge."""
        step, closest = self._steady_step, CLOSEST * self.problem.tolerance
        state, modes = step.iterate(P), len(self.problem.force)
        for _ in range(_FINAL_STEPS):
            after = step.newton(state)
            if after is None:
                # Near a limit point no step may be better than none.
                if step.unbalanced(state) > closest:
                    return None
                return self._found(state)
            amplitude, before = (np.diagonal(each.modal)[:modes] for each in (after, state))
            change = relative_error(self.problem.reduced, amplitude - before, amplitude)
            state = after
            # Contact forces are up to ten times the forces that balance them in a steady state.
            if max(change, step.unbalanced(state), 10.0 * step.residual(state)) <= closest:
                return self._found(state)
        return None

    def _found(self, state: _Iterate) -> SteadyHarmonics:
        amplitude = np.diagonal(state.modal)[: len(self.problem.force)]
        nu = self.receptance.frequency
        return SteadyHarmonics(amplitude, list(self.orders), nu, state.modal, state.P)

    def _after_transient(self, P: Complexes, modal: Complexes) -> SteadyHarmonics:
        """Return the steady state to which the slow flow leads."""
        length, tried = self._slip_time, 10.0 * self._slip_time
        for _ in range(_MOST_TIME_STEPS):
            step = _TimeStep(self, length, modal)
            before = step.iterate(P)
            after = step.newton(before)
            if after is None:
                length *= _SHORTER
                continue
            change = np.linalg.norm(after.modal - modal)
            P, modal = after.P, after.modal
            converges = step.residual(after) <= _CONVERGING * step.residual(before)
            length *= _LONGER if converges else 1.0 / _LONGER
            nearly = change <= _NEARLY_STEADY * np.linalg.norm(modal)
            if nearly and length >= _LONGER * tried:
                found = self._steady(P)
                if found is not None:
                    return found
                # The basin of Newton's method is small, or a mode changes very slowly.
                tried = length
        raise self._refusal(step, P)

    @cached_property
    def _slip_time(self) -> float:
        """Time in which full slip turns the phase of an amplitude by 1, or it decays [s]."""
        reduced = self.problem.reduced
        own = np.arange(len(self.problem.force))
        B = self.receptance.B[own, own]
        if reduced.contacts is not None:
            detuning = np.abs(B) ** 2 @ reduced.contacts.reference
        else:
            moved = np.linalg.solve(reduced.stiffness, B.conj().T)
            detuning = np.abs(np.einsum("jc,cj->j", B, moved))
        rate = np.abs(detuning) / reduced.carrier + reduced.modal_damping
        return float(2.0 / np.maximum(rate, np.finfo(float).eps * reduced.carrier).max())

    def _refusal(self, step: _TimeStep, P: Complexes) -> SlipmodeError:
        off = step.residual(step.iterate(P))
        response, advice = resonance_words(self.problem.reduced, self.orders)
        return SlipmodeError(
            f"frequency: no steady state was found. The residual is {percentage(min(off, 1.0))}. "
            f"{response}, so the motion may not be periodic; {advice}move the forcing, give "
            "damping to that mode, or integrate in time (rom.full)"
        )


@frozen
class _TimeStep:
    """A step of implicit Euler from the modes `before`; of infinite length: the steady state.

    With D' = D + 2 i nu / length, modes near a harmonic are D' q = f / 2 - B P + (2 i nu / length)
    before; the others respond at once.
    """

    balance: ForcedBalance
    length: float  # [s]
    before: Complexes  # (orders, modes + nonresonant) [kg^1/2 m]

    @cached_property
    def _response(self) -> tuple[Complexes, Complexes, Floats]:
        """Modes without contacts, modes per P, and weights (N_c,) of the contacts."""
        at = self.balance.receptance
        rate = np.where(at.resonant, 2j * at.frequency[:, np.newaxis] / self.length, 0.0)
        D = at.D + rate[..., np.newaxis] * np.eye(at.D.shape[-1])
        loads = at.loads + rate * self.before
        both = np.linalg.solve(D, np.concatenate((loads[..., np.newaxis], -at.B), axis=-1))
        weight = np.linalg.norm(at.B[: len(self.balance.problem.force)], axis=(0, 1))
        weight = np.asarray(np.maximum(weight, np.finfo(float).tiny), dtype=float)
        return np.asarray(both[..., 0]), np.asarray(both[..., 1:]), weight

    def unbalanced(self, state: _Iterate) -> float:
        """Return the largest response of a mode to the residual, relative to the largest mode."""
        moved = np.einsum("qkc,qc->qk", self._response[1], state.F - state.P)
        largest = max(float(np.abs(state.modal).max()), np.finfo(float).tiny)
        return float(np.abs(moved).max()) / largest

    def residual(self, state: _Iterate) -> float:
        """Return the size of F(P) - P, weighted by the effect of contacts, relative to P."""
        off, F, P = (
            float(np.linalg.norm(each * self._response[2]))
            for each in (state.F - state.P, state.F, state.P)
        )
        return off / max(F, P, _LEAST_FORCE * float(np.linalg.norm(self.balance.receptance.loads)))

    def iterate(self, P: Complexes, guess: Complexes | None = None) -> _Iterate:
        """Return P with F(P)."""
        at, problem = self.balance.receptance, self.balance.problem
        alone, per_contact, _ = self._response
        modal = alone + np.einsum("qkc,qc->qk", per_contact, P)
        forces = np.einsum("qcd,qd->qc", at.follows, P) - np.einsum("qkc,qk->qc", at.B, modal)
        pushed = 0.5 * problem.force @ problem.reduced.contact_shapes
        forces[: len(pushed)] += pushed
        F = self.balance.contact_motion(forces, P if guess is None else guess)
        return _Iterate(P, F, modal)

    def newton(self, state: _Iterate) -> _Iterate | None:
        """Return the state after a Newton step, None where the residual does not fall."""
        residual = self.residual(state)
        if residual <= _ROUNDING * self.balance.problem.tolerance:
            return state
        direction = self._direction(state, min(max(residual, 0.01), 0.1))
        for part in _PARTS:
            after = self.iterate(state.P + part * direction)
            remaining = self.residual(after)
            if remaining <= (1.0 - 0.3 * part) * residual:
                return after
        return after if remaining < residual else None

    def _direction(self, state: _Iterate, tolerance: float) -> Complexes:
        """Return the Newton step (orders, N_c) to a relative tolerance."""
        weight = self._response[2]
        residual = ((state.F - state.P) * weight).ravel().view(float)
        motion = max(np.abs(state.P * weight).max(), np.abs(state.F * weight).max())

        def change(v: Floats) -> Floats:
            part = _DIFFERENCE * motion / np.abs(v).max()
            moved = (part * v).view(complex).reshape(state.P.shape) / weight
            F = self.iterate(state.P + moved, state.P).F
            return np.asarray(v - ((F - state.F) * weight).ravel().view(float) / part)

        operator = scipy.sparse.linalg.LinearOperator(
            (residual.size, residual.size), matvec=change, dtype=float
        )
        step, _ = scipy.sparse.linalg.gmres(
            operator, residual, rtol=tolerance, restart=_MOST_DIRECTIONS, maxiter=1
        )
        return np.asarray(step.view(complex).reshape(state.P.shape) / weight)
