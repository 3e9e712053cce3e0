"""What the motion of the contacts does to the modes, Eq. (20), and what it loses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.harmonics import left_out
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import contact_harmonics, reaction_stiffnesses
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CombinationResonance, Order, harmonic_orders
from slipmode.rom.reduction.force_response import steady_coupling
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.short_repr import short_repr


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
    amplitudes : (points, modes) ndarray
        [kg^1/2 m]
    orders : list of (n, m)
        Harmonics in P.
    P : (points, orders, N_c) complex ndarray
        Of the contact displacement [m].
    mean_square : (points, N_c) ndarray
        Of the contact displacement [m^2].
    residual : (points,) ndarray
        Distance from periodicity.
    marched : (points,) ndarray of int
        Time steps marched along each phase line.
    """

    S: Complexes
    T: Complexes
    amplitudes: Floats
    orders: list[Order]
    P: Complexes
    mean_square: Floats
    residual: Floats
    marched: NDArray[np.int32]
    _of: _Projection

    __repr__ = short_repr

    @property
    def left_out(self) -> Floats:
        """RMS of the contact displacement beyond these harmonics [m], (points, N_c)."""
        return left_out(self.orders, self.P, self.mean_square)

    @property
    def power(self) -> Floats:
        """Mean power that friction dissipates [W], (points,)."""
        return self._of.friction_power(self.amplitudes, self.P)

    @property
    def leaving(self) -> Floats:
        """Mean power that leaves the modes at the contacts [W]; dampers share it with friction."""
        return np.asarray(-2.0 * (self.amplitudes * self.S.imag) @ self._of.carrier)

    def take(self, points: NDArray[np.intp], other: ContactTerms) -> None:
        """Take those at some points from elsewhere."""
        for name in ("S", "T", "P", "mean_square", "residual", "marched"):
            getattr(self, name)[points] = getattr(other, name)


def contact_orders(
    reduced: Reduced,
    combinations: Sequence[CombinationResonance] = (),
    highest: int = 1,
    further: Sequence[Order] = (),
) -> list[Order]:
    """Those that are asked for, those that modes always respond to, and others."""
    responding = _up_to(reduced, RESPONSE_ORDER) if reduced.formulation == "consistent" else []
    asked = _asked(reduced, combinations, highest)
    return list(dict.fromkeys([*asked, *responding, *further]))


def _asked(
    reduced: Reduced, combinations: Sequence[CombinationResonance], highest: int
) -> list[Order]:
    """Harmonics up to an order, and of combination resonances."""
    resonant = (term.stored_order for term in combinations)
    return list(dict.fromkeys([*_up_to(reduced, highest), *resonant]))


def _up_to(reduced: Reduced, highest: int) -> list[Order]:
    return harmonic_orders(highest, len(reduced.modes), reduced.even)


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
        *(near, len(_asked(reduced, combinations, highest))),
    )
    a, P = kernel.contiguous(amplitudes), solved.P
    projection = _projection(reduced, tuple(orders), tuple(combinations))
    S = np.where(a == 0.0, 0.0, projection.forces(P) - reduced.indirect_damping * a)
    return ContactTerms(
        *(S, projection.combined(P), a, orders, P),
        *(solved.mean_square, solved.residual, solved.marched, projection),
    )


@dataclass(frozen=True, eq=False)
class _Projection:
    """How harmonics P (points, orders, N_c) of the contacts act on the modes, and what they lose.

    Attributes
    ----------
    carrier : (modes,) ndarray
        [rad/s]
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

    carrier: Floats
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
        work = (P.swapaxes(0, 1) @ self.lost).swapaxes(0, 1)
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
        reduced.carrier,
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
