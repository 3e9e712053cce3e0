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
from slipmode.rom.contact.torus import ContactHarmonics, Discretisation, torus_harmonics
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import Order, harmonic_orders
from slipmode.rom.reduction.internal_resonance import strongest_resonance
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr

_FIRST_STEP = 0.1  # kappa, times how far slip can detune the mode
_UNSETTLED = 1e-2  # distance from periodicity from where a step was too long
_STEPS = 60
# Of the contacts' motion, by modes: far from the steady state, and at it by the tolerance. With
# two the phases of the lines drift against the grid; that is only as small as its error.
_COARSE = {1: 1e-4, 2: 1e-3}
_PRECISION = {1: 0.01, 2: 0.1}
_PATIENCE = 3
_LONGEST_MOVE = 0.5  # by secants, of the largest amplitude
_WEAK = 0.1  # contact motion of a mode, of the strongest's: its error is relative to that below
_SMALL = 0.03  # response to a harmonic that does not count, of the tolerance
_LINES = (16, 32, 64, 128)


@dataclass(frozen=True, eq=False)
class Balanced:
    """Harmonics 2 Re(c_nm exp(i (n t_A + m t_B))) of a steady state, the carriers first.

    Attributes
    ----------
    amplitude : (modes,) complex ndarray
        a_j of the retained modes at their carriers [kg^1/2 m].
    off : (modes,) ndarray
        By what the next step would change them [kg^1/2 m].
    orders : list of (n, m)
    frequency : (orders,) ndarray
        n Omega_A + m Omega_B [rad/s].
    modal : (orders, modes + nonresonant) complex ndarray
        Displacement of all modes [kg^1/2 m].
    P : (orders, N_c) complex ndarray
        Of the contact displacement [m].
    grid : Discretisation
    """

    amplitude: Complexes
    off: Floats
    orders: list[Order]
    frequency: Floats
    modal: Complexes
    P: Complexes
    grid: Discretisation

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class _Receptance:
    """What all modes do at the harmonics, (orders, ...): D, B and the reaction on the contacts."""

    frequency: Floats
    D: Complexes
    B: Complexes
    follows: Complexes
    reaction: Complexes

    @classmethod
    def of(cls, reduced: Reduced, orders: Sequence[Order]) -> _Receptance:
        nu = np.array(orders, dtype=float)[:, : len(reduced.modes)] @ reduced.carrier
        D, B, follows = (
            reduced.modal_stiffness(nu),
            reduced.modal_coupling(nu),
            reduced.following(nu),
        )
        return cls(nu, D, B, follows, np.swapaxes(B, 1, 2) @ np.linalg.solve(D, B) + follows)


@dataclass(frozen=True, eq=False)
class _Step:
    """Where one step of implicit Euler ends: contacts, and all modes at the carriers."""

    solved: ContactHarmonics
    modal: Complexes
    drawn: float

    @property
    def amplitude(self) -> Complexes:
        return np.diagonal(self.modal).copy()


@dataclass(frozen=True, eq=False)
class ForcedBalance:
    """The balance under forces 2 half cos(Omega_j t), (modes, n)."""

    reduced: Reduced
    law: Friction
    half: Floats
    tolerance: float

    def solve(
        self, orders: Sequence[Order], grid: Discretisation, start: Balanced | None
    ) -> Balanced:
        """The steady state with these harmonics, the carriers first, on this grid."""
        modes = len(self.half)
        receptance = _Receptance.of(self.reduced, orders)
        target, P = np.zeros(modes, dtype=complex), None
        if start is not None:
            target, P = start.amplitude, _extended(start, orders)
        kappa = _FIRST_STEP * self.detuning
        secants = _Secants(modes)
        closest, far, least, idle = 0.1 * self.tolerance, 1.0, np.inf, 0
        for _ in range(_STEPS):
            precision = float(
                np.clip(0.1 * far, _PRECISION[modes] * self.tolerance, _COARSE[modes])
            )
            step = self._step(receptance, orders, grid, kappa, target, P, precision)
            if step.solved.residual[0] > _UNSETTLED:
                kappa, secants = 3.0 * kappa, _Secants(modes)
                continue
            P, amplitude = step.solved.P[0], step.amplitude
            target = secants.next(amplitude, 1j * kappa * (amplitude - target))
            far = self.relative(target - amplitude, amplitude) if secants.known else 1.0
            idle = 0 if far < 0.5 * least else idle + 1
            least = min(far, least)
            if far <= closest or (far <= self.tolerance and idle >= _PATIENCE):
                loads = -np.einsum("qkc,qc->qk", receptance.B, P)
                loads[:modes] += self.half @ self.reduced.all_shapes
                modal = np.linalg.solve(receptance.D, loads[..., np.newaxis])[..., 0]
                modal[:modes] = step.modal
                return Balanced(
                    amplitude=amplitude,
                    off=np.abs(target - amplitude),
                    orders=list(orders),
                    frequency=receptance.frequency,
                    modal=np.asarray(modal),
                    P=P,
                    grid=grid,
                )
        raise self._refusal(orders, step.solved)

    def responding(self, state: Balanced, highest: int) -> tuple[list[Order], float]:
        """Further harmonics up to an order that modes respond to, and what others would do.

        Both by their share in the displacement of the contacts.
        """
        candidates = harmonic_orders(highest, len(self.half), self.reduced.even)
        further = [order for order in candidates if order not in state.orders]
        orders = [*state.orders, *further]
        receptance = _Receptance.of(self.reduced, orders)
        held = receptance.reaction.copy()
        held[len(state.orders) :] = 0.0
        step = self._step(
            replace(receptance, reaction=held),
            orders,
            replace(state.grid, lines=enough_lines(orders, state.grid.lines)),
            _FIRST_STEP * self.detuning,
            state.amplitude,
            _extended(state, orders),
            _COARSE[len(self.half)],
        )
        moved = np.einsum("qcd,qd->qc", receptance.reaction, step.solved.P[0])
        share = np.abs(moved[len(state.orders) :]).max(axis=1) / step.drawn
        wanted = share > _SMALL * self.tolerance
        return (
            [order for order, counts in zip(further, wanted, strict=True) if counts],
            float(share[~wanted].sum()),
        )

    def _step(
        self,
        receptance: _Receptance,
        orders: Sequence[Order],
        grid: Discretisation,
        kappa: Floats,
        target: Complexes,
        start: Complexes | None,
        tolerance: float,
    ) -> _Step:
        """(D + i kappa) a = F / 2 - L^T P + i kappa target, with the contacts that it leads to."""
        modes = np.arange(len(self.half))
        D, B = receptance.D[modes], receptance.B[modes]
        loads = (self.half @ self.reduced.all_shapes).astype(complex)
        D[modes, modes, modes] += 1j * kappa
        loads[modes, modes] += 1j * kappa * target
        responding = np.linalg.solve(D, B)
        free = np.linalg.solve(D, loads[..., np.newaxis])[..., 0]
        coupling = np.einsum("jkc,jk->jc", B, free) - self.half @ self.reduced.contact_shapes
        reaction = receptance.reaction.copy()
        reaction[modes] = np.swapaxes(B, 1, 2) @ responding + receptance.follows[modes]
        solved = torus_harmonics(
            *(self.reduced, self.law, coupling, reaction, np.ones((1, modes.size)), grid, orders),
            tolerance=tolerance,
            start=start,
        )
        P = solved.P[0, modes]
        drawn = np.einsum("jcd,jd->jc", reaction[modes], P) - coupling
        q = free - np.einsum("jkc,jc->jk", responding, P)
        return _Step(solved, q, float(np.abs(drawn).max()))

    def relative(self, error: Complexes | Floats, amplitude: Complexes) -> float:
        """The largest of errors (modes,) of amplitudes."""
        moves = np.linalg.norm(self.reduced.coupling, axis=1)
        motion = moves * np.abs(amplitude)
        scale = np.maximum(motion, _WEAK * motion.max())
        return float((moves * np.abs(error) / np.maximum(scale, np.finfo(float).tiny)).max())

    @property
    def detuning(self) -> Floats:
        """How far slip can detune the modes, (modes,) [rad^2/s^2]."""
        L, contacts = self.reduced.coupling, self.reduced.contacts
        if contacts is not None:
            return np.asarray(np.abs(L) ** 2 @ contacts.reference)
        moved = np.linalg.solve(self.reduced.stiffness, L.T)
        return np.asarray(np.abs(np.einsum("jc,cj->j", L, moved)))

    def _refusal(self, orders: Sequence[Order], solved: ContactHarmonics) -> SlipmodeError:
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
    return max(least, next((n for n in _LINES if n > 2 * highest), _LINES[-1]))


class _Secants:
    """Where the imbalance would be 0, by its last changes (Anderson 1965)."""

    def __init__(self, modes: int) -> None:
        self._most = 2 * modes
        self._points: list[Floats] = []

    @property
    def known(self) -> bool:
        """Whether there is one."""
        return len(self._points) > 1

    def next(self, amplitude: Complexes, imbalance: Complexes) -> Complexes:
        """The next amplitude (modes,)."""
        self._points = [
            *self._points[-self._most :],
            np.concatenate((amplitude, imbalance)).view(float),
        ]
        if not self.known:
            return amplitude
        last, size = self._points[-1], 2 * amplitude.size
        changes = np.array([last - before for before in self._points[:-1]]).T
        theta = np.linalg.lstsq(changes[size:], last[size:], rcond=1e-6)[0]
        move = (changes[:size] @ theta).view(complex)
        most = _LONGEST_MOVE * np.abs(amplitude).max()
        return np.asarray(amplitude - move * min(1.0, most / max(np.abs(move).max(), 1e-300)))


def _extended(state: Balanced, orders: Sequence[Order]) -> Complexes:
    """Its contact harmonics for other orders, 0 where it had none."""
    known = dict(zip(state.orders, state.P, strict=True))
    nothing = np.zeros(state.P.shape[1], dtype=complex)
    return np.array([known.get(order, nothing) for order in orders])
