"""What the motion of the contacts does to the modes, Eq. (20), and the energy that it loses."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.harmonics import left_out
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.combination import CombinationResonance, Order
from slipmode.rom.reduction.force_response import steady_force
from slipmode.rom.reduction.interaction.mode_proposals import resonance_words
from slipmode.rom.short_repr import frozen, percentage

if TYPE_CHECKING:
    from slipmode.rom.contact.problem import ContactProblem

# Distance from periodicity above which a solution has no meaning.
LARGEST_RESIDUAL = 0.05


@frozen
class ContactTerms:
    """Periodic motion of the contacts at several amplitudes.

    Attributes
    ----------
    problem : ContactProblem
    amplitudes : (points, modes) ndarray
        |a_j| [kg^1/2 m].
    P : (points, orders, N_c) complex ndarray
        Harmonics of the contact displacement [m], Eq. (14).
    mean_square : (points, N_c) ndarray
        Of the contact displacement [m^2].
    residual : (points,) ndarray
        Estimated distance from periodicity, relative to the frictionless displacement.
    marched : (points,) ndarray of int
        Time steps marched along each phase line.
    """

    problem: ContactProblem
    amplitudes: Floats
    P: Complexes
    mean_square: Floats
    residual: Floats
    marched: NDArray[np.int32]

    @classmethod
    def at_rest(cls, problem: ContactProblem, amplitudes: Floats) -> Self:
        """Return the terms without contact motion, as of elastic contacts that stick."""
        points, contacts = len(amplitudes), problem.reduced.n_contacts
        P = np.zeros((points, len(problem.orders), contacts), dtype=complex)
        still = np.zeros(points, dtype=np.int32)
        return cls(problem, amplitudes, P, np.zeros((points, contacts)), np.zeros(points), still)

    @property
    def orders(self) -> list[Order]:
        """Harmonics (n, m) in P."""
        return list(self.problem.orders)

    @property
    def is_periodic(self) -> Flags:
        """Where the motion is about periodic, (points,)."""
        return np.asarray(self.residual <= LARGEST_RESIDUAL)

    @cached_property
    def S(self) -> Complexes:  # noqa: N802
        """Q_j |a_j| of Eq. (20) and the force through dampers from other modes, (points, modes).

        [N kg^-1/2]; exactly 0 where |a_j| = 0.
        """
        reduced, a = self.problem.reduced, self.amplitudes
        carriers = self.P[:, : a.shape[1]]
        projection, indirect = self.problem.forces.projection, self.problem.forces.indirect
        projection = reduced.coupling if projection is None else projection
        indirect = reduced.indirect_damping if indirect is None else indirect
        force = -np.einsum("jc,pjc->pj", projection, carriers)
        return np.where(a == 0.0, 0.0, force - indirect * a)

    @property
    def Q(self) -> Complexes:  # noqa: N802
        """Friction functions Q_j = S_j / |a_j| of Eq. (20), (points, modes) [rad^2/s^2]."""
        return np.asarray(self.S / self.amplitudes)

    @cached_property
    def T(self) -> Complexes:  # noqa: N802
        """-L_j^T P_nm of the combination resonances, (points, combinations) [N kg^-1/2]."""
        T = np.zeros((len(self.P), len(self.problem.combinations)), dtype=complex)
        for k, term in enumerate(self.problem.combinations):
            T[:, k] = -self._harmonic(term) @ self.problem.reduced.coupling[term.mode]
        return T

    def _harmonic(self, term: CombinationResonance) -> Complexes:
        """P_nm of a combination resonance, (points, N_c)."""
        P = self.P[:, self.problem.orders.index(term.stored_order)]
        return P if term.stored_order == (term.n, term.m) else P.conj()

    def at_carriers(self, turn: Complexes) -> Complexes:
        """Return the motion of the contacts at the carriers, (points, modes, N_c) [m].

        `turn` (points, modes) is exp(i arg a_j). Harmonics that modes on one tone have at the same
        frequency are together.
        """
        modes = turn.shape[1]
        found = self.P[:, :modes] * turn[..., np.newaxis]
        for term in self.problem.combinations if self.problem.reduced.ratio else ():
            beat = turn[:, 0] ** term.n * turn[:, 1] ** term.m
            found[:, term.mode] += beat[:, np.newaxis] * self._harmonic(term)
        return np.asarray(found)

    @property
    def left_out(self) -> Floats:
        """RMS of the contact displacement beyond these harmonics, (points, N_c) [m]."""
        return left_out(self.orders, self.P, self.mean_square)

    @property
    def power(self) -> Floats:
        """Mean power that friction dissipates, (points,) [W].

        A force 2 Re(F exp(i nu t)) on a displacement 2 Re(P exp(i nu t)) does the mean work
        2 Re(F conj(i nu P)). Friction dissipates the work of all other forces on the contacts.
        """
        reduced, forces = self.problem.reduced, self.problem.forces
        modes = self.amplitudes.shape[1]
        velocity = 1j * (np.array(self.orders)[:, :modes] @ reduced.carrier)
        response = forces.reaction
        if reduced.contacts is None:
            response = response - velocity[:, np.newaxis, np.newaxis] * reduced.damping
        force = (self.P.swapaxes(0, 1) @ response.swapaxes(1, 2)).swapaxes(0, 1)
        force[:, :modes] -= self.amplitudes[..., np.newaxis] * forces.coupling
        work = force * (velocity[:, np.newaxis] * self.P).conj()
        return np.asarray(np.maximum(2.0 * work.real.sum(axis=(1, 2)), 0.0))

    @property
    def leaving(self) -> Floats:
        """Mean power that leaves the modes at the contacts, (points,) [W].

        Friction and the dampers between the modes dissipate it.
        """
        loss = self.amplitudes * self.S.imag
        return np.asarray(-2.0 * loss @ self.problem.reduced.carrier)

    @property
    def by_forces(self) -> Floats:
        """Mean power of the steady forces on the contacts besides their shift, (points,) [W].

        It is part of `power`, but does not leave the modes.
        """
        reduced, a = self.problem.reduced, self.amplitudes
        carriers = self.P[:, : a.shape[1]]
        per_stiffness, D = steady_force(reduced)
        on_mode = D * a + np.einsum("pjc,jc->pj", carriers, reduced.coupling)
        velocity = 1j * reduced.carrier[:, np.newaxis] * carriers
        work = np.einsum("pj,jc,pjc->p", on_mode, per_stiffness, velocity.conj())
        return np.asarray(2.0 * work.real)

    def replaced(self, points: NDArray[np.intp], other: ContactTerms) -> ContactTerms:
        """Return the terms with the terms `other` at some points."""
        arrays = {}
        for name in ("P", "mean_square", "residual", "marched"):
            arrays[name] = getattr(self, name).copy()
            arrays[name][points] = getattr(other, name)
        return replace(self, **arrays)

    def check_periodic(self) -> None:
        """Refuse motion that is not periodic.

        Raises
        ------
        UnsettledError
            Naming the mode that responds most, and the harmonic to which it does.
        """
        if self.is_periodic.all():
            return
        off = float(self.residual.max())
        reduced = self.problem.reduced
        response, advice = resonance_words(reduced, self.orders, self.problem.combinations)
        part = percentage(off) if off <= 1.0 else "more than 100 %"
        rigid = ""
        if reduced.contacts is None:
            rigid = "let contacts be elastic while they stick (rom.Jenkins), "
        raise UnsettledError(
            "contacts: the response of the modes to the contact forces does not converge. It "
            f"changes by {part} in a period. {response}; {rigid}{advice}move the forcing away "
            "from it, give it damping, lower the largest amplitudes, or integrate in time "
            "(rom.full)"
        )
