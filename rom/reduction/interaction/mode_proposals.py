"""Which modes must be retained together: neighbours, and modes that a harmonic of contacts meets.

Slip of the contacts lowers the square of a natural frequency from its stuck value omega^2 by at
most about kappa, the modal stiffness due to contacts. A mode B responds to harmonic h of a mode A
if h times the frequency of A passes the frequency of B. Neighbours respond at h = 1, also to the
force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.frequencies import LOWEST_CARRIER
from slipmode.rom.reduction.combination import CombinationResonance, Order
from slipmode.rom.reduction.interaction.internal_resonance import (
    harmonic_gain,
    strongest_resonance,
)
from slipmode.rom.reduction.nonresonant import MOST_MODES
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.reduction.tones import FARTHEST, LARGEST_INTEGER
from slipmode.rom.short_repr import frozen, percentage

# Expected change of the amplitude of a mode from which another one is proposed. On drawn
# structures it was larger wherever the friction of one mode was wrong by more than 1 %
# (tests/rom/reduction/test_mode_proposals.py).
_SMALLEST_EFFECT = 5e-3
# Distance of a harmonic from the frequencies of a mode, relative to them, beyond which the mode is
# not proposed: the forcing frequency then hardly changes its response.
_MARGIN = 0.03
_EQUAL = 1e-5  # relative distance of frequencies that are called equal
# Largest damping of a mode by a contact that sticks and slides, |Im Q| relative to kappa.
_LARGEST_DAMPING = 1.0 / np.pi
_TIMES = ("", "", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_TINY = np.finfo(float).tiny


class Retention(NamedTuple):
    """Modes that are retained, and which other modes `rom.reduce` can retain with them."""

    modes: tuple[int, ...]
    elastic: bool  # whether the law is given to `rom.reduce`
    even: bool  # whether contacts lift off, so that they have even harmonics as well
    tones: int = 1  # with a force each

    @classmethod
    def of(cls, reduced: Reduced) -> Self:
        """Return the modes of a reduced structure."""
        return cls(reduced.modes, reduced.contacts is not None, reduced.even, reduced.tones)

    def advice(self, others: Sequence[int], order: int, carrier: float | None = None) -> str:
        """Return how to retain other modes at an order of the carrier; "" if that cannot be.

        `carrier` [rad/s] is where the harmonic meets the mode, if not near the natural frequency.
        """
        shared, modes = order == 1, (*self.modes, *others)
        if shared:
            allowed, modes = self.elastic and not self.even, tuple(sorted(modes))
        else:
            allowed = len(modes) == 2 and order <= LARGEST_INTEGER
        if self.tones > 1 or not allowed:
            return ""
        key = f"tones={(0,) * len(modes)}" if shared else f"ratio={order}"
        key += f", carrier=[{carrier:.4g}]" if carrier is not None else ""
        law = ", law=law" if self.elastic else ""
        keys = f"A = {list(modes)}" if shared else f"B = {others[0]}, ratio = {order}"
        scene = f", in a scene [modes] {keys}"
        call = f"rom.reduce(structure, {modes}, {key}{law})"
        return f"retain {_named(others)} as well, {call}{scene}"


@frozen
class ModeProposal:
    """Modes that must be retained together with a forced mode, and why.

    Attributes
    ----------
    mode : int
        Number of the forced mode.
    others : tuple of int
        Modes to retain as well.
    order : int
        Harmonic of its frequency at which they respond; 1 for its neighbours.
    effect : float
        Expected change of its amplitude without them, relative to it, at most [-].
    reason, advice : str
        Why, and how to retain them.
    """

    mode: int
    others: tuple[int, ...]
    order: int
    effect: float
    reason: str
    advice: str

    def __str__(self) -> str:
        return f"{self.reason}; {self.advice}"


@frozen
class ContactModes:
    """Modes of a structure with stuck or bonded contacts, and how contacts couple them.

    Attributes
    ----------
    number : (count,) ndarray of int
        As in `rom.modes`.
    frequency, damping : (count,) ndarray
        Natural frequencies [rad/s] and modal damping [1/s].
    shared : (count, count) ndarray
        Stiffness of contacts that two modes move, sum_c k_c |psi_Ac psi_Bc| [rad^2/s^2]; the modal
        stiffness kappa due to contacts on the diagonal.
    """

    number: NDArray[np.intp]
    frequency: Floats
    damping: Floats
    shared: Floats

    @classmethod
    def of_reduced(cls, reduced: Reduced) -> Self:
        """Return the retained and the nonresonant modes, as `rom.reduce` found them."""
        omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
        others = np.delete(np.arange(omega.size + max(reduced.modes)), reduced.modes)
        springs, inertia, _ = reduced.coupling_parts
        coupling = np.abs(springs - omega[:, np.newaxis] ** 2 * inertia)
        if reduced.contacts is None:
            flexibility = np.abs(np.linalg.inv(reduced.stiffness))
        else:
            flexibility = np.diag(reduced.contacts.reference)
        number = np.append(reduced.modes, others)[: omega.size]
        damping = np.abs(np.append(reduced.modal_damping, reduced.nonresonant_damping))
        return cls(number, omega, damping, coupling @ flexibility @ coupling.T)

    def with_slip(self, share: float) -> Self:
        """Return the modes where slip takes only a share of kappa from their stiffness."""
        return replace(self, shared=share * self.shared)

    def proposals(
        self,
        mode: int,
        retention: Retention,
        span: tuple[float, float] | None = None,
        force: Floats | None = None,
    ) -> list[ModeProposal]:
        """Return the modes to retain with a forced mode, its neighbours first.

        Parameters
        ----------
        mode : int
            Number of the forced mode.
        retention : Retention
            Modes that are retained.
        span : (float, float), optional
            Smallest and largest forcing frequency [rad/s]. Default: from free to stuck contacts.
        force : (count,) ndarray, optional
            Modal forces, in any scale.
        """
        at = int(np.flatnonzero(self.number == mode)[0])
        high = float(self.frequency[at])
        low, high = span or (max(float(self._softest[at]), LOWEST_CARRIER * high), high)
        return [
            *self._neighbours(at, retention, low, high, force),
            *self._at_harmonics(at, retention, low, high),
        ]

    @property
    def _softest(self) -> Floats:
        """Lowest natural frequencies while contacts slip, to first order, (count,) [rad/s]."""
        return np.asarray(np.sqrt(np.maximum(self.frequency**2 - self.shared.diagonal(), 0.0)))

    def _neighbours(
        self, at: int, retention: Retention, low: float, high: float, force: Floats | None
    ) -> list[ModeProposal]:
        """Return at most one proposal, of the modes that respond at the frequency of a mode."""
        by_contacts, dynamic = self._effect(at, 1, low, high)
        by_force = np.zeros_like(by_contacts)
        if force is not None and force[at] != 0.0:
            by_force = np.abs(force / force[at] * dynamic[at] / dynamic)
        effect = np.maximum(by_contacts, by_force)
        # Modes on two tones that are close beat slowly, whatever couples them.
        effect[np.isin(self.number, retention.modes)] = float(retention.tones > 1)
        effect[at] = 0.0
        retained = np.flatnonzero(np.isin(self.number, retention.modes)).tolist()
        tone = [at] if retention.tones > 1 else retained
        others: list[int] = []
        for other in _strongest(effect):
            together = self.frequency[[*tone, *others, other]]
            if together.max() <= (1.0 + FARTHEST) * together.min():
                others.append(other)
        if not others:
            return []
        ratio = self.frequency[others] / self.frequency[at]
        distance, mode = float(np.abs(ratio - 1.0).max()), self.number[at]
        does = "respond to the force"
        if self.number[others[0]] in retention.modes:
            does = "have a tone of their own"
        elif by_contacts[others].max() >= by_force[others].max():
            does = "move the contacts"
        reason = f"modes within {percentage(distance)} of mode {mode} {does} too"
        if len(others) == 1:
            place = f"{percentage(distance)} {'above' if ratio[0] > 1.0 else 'below'}"
            place = place if distance > _EQUAL else "at the frequency of"
            reason = f"mode {self.number[others[0]]} is {place} mode {mode}, and both {does}"
        return [self._proposal(at, others, 1, effect, reason, retention)]

    def _at_harmonics(
        self, at: int, retention: Retention, low: float, high: float
    ) -> list[ModeProposal]:
        """Return the modes that a multiple of a frequency from `low` to `high` [rad/s] meets."""
        found: dict[int, ModeProposal] = {}  # the strongest harmonic of each mode
        mode, rigid = self.number[at], np.where(self.frequency > 0.0, 0.0, np.inf)
        for order in range(2, LARGEST_INTEGER + 1):
            if order % 2 == 0 and not retention.even:
                continue
            effect, _ = self._effect(at, order, order * low, order * high)
            below = np.divide(order * low, self.frequency, out=rigid.copy(), where=rigid == 0.0)
            beyond = np.maximum(self._softest / (order * high), below) - 1.0
            effect[(beyond > _MARGIN) | np.isin(self.number, retention.modes)] = 0.0
            for other in _strongest(effect):
                if other in found and found[other].effect >= effect[other]:
                    continue
                meets = "passes" if beyond[other] <= 0.0 else "comes close to"
                reason = (
                    f"{_TIMES[order]} times the frequency of mode {mode} {meets} the frequency of "
                    f"mode {self.number[other]}, and both move the contacts, which changes the "
                    f"amplitude by up to about {percentage(float(min(effect[other], 1.0)))}"
                )
                found[other] = self._proposal(at, [other], order, effect, reason, retention)
        return list(found.values())

    def _effect(self, at: int, order: int, low: float, high: float) -> tuple[Floats, Complexes]:
        """Return the expected change of the amplitude of a mode by the response of each mode.

        And the smallest dynamic stiffness of each, (count,) [rad^2/s^2], at the harmonic between
        `low` and `high` [rad/s].
        """
        own = self.shared.diagonal()
        gap = np.maximum(self._softest**2 - high**2, low**2 - self.frequency**2)
        damping = self.damping * np.clip(self.frequency, low, high) + _LARGEST_DAMPING * own
        dynamic = np.maximum(gap, 0.0) + 1j * damping
        # Mode B responds to contacts that mode A moves, and changes their forces on mode A, beside
        # which mode A has its own damping.
        response = harmonic_gain(self.shared[at], dynamic, order**2)
        beside = own[at] + self.damping[at] * self.frequency[at] / _LARGEST_DAMPING
        return response * self.shared[at] / max(beside, _TINY), dynamic

    def _proposal(
        self,
        at: int,
        others: list[int],
        order: int,
        effect: Floats,
        reason: str,
        retention: Retention,
    ) -> ModeProposal:
        numbers, carrier = tuple(sorted(self.number[others].tolist())), None
        meeting = float(self.frequency[others[0]]) / order
        if order > 1 and abs(float(self.frequency[at]) / meeting - 1.0) > FARTHEST:
            carrier = meeting
        advice = retention.advice(numbers, order, carrier)
        return ModeProposal(
            int(self.number[at]),
            numbers,
            order,
            float(effect[others].max()),
            reason,
            advice or "use rom.steady_state, or time integration (rom.full)",
        )


def resonance_words(
    reduced: Reduced, orders: Sequence[Order], combinations: Sequence[CombinationResonance] = ()
) -> tuple[str, str]:
    """Return which mode responds most to a harmonic of contacts, and advice to retain it, if any.

    For refusals of contact motion that does not converge; the advice ends with a comma.
    """
    met = strongest_resonance(reduced, orders, combinations)
    n, m = met.order
    words = f"The {met.mode} responds most, to harmonic ({n}, {m}) at {met.harmonic:.4g} rad/s"
    apart = met.frequency / (max(n, 1) * float(reduced.frequency[0])) - 1.0
    if m != 0 or abs(apart) > FARTHEST or reduced.structure is None:
        return words, ""
    reach = 1.01 * met.frequency / float(reduced.structural_frequency.max())
    modes, _ = reduced.held(reduced.structure).modes(max(reduced.modes) + 1, MOST_MODES, reach)
    number = int(np.abs(modes - met.frequency).argmin())
    advice = Retention.of(reduced).advice([number], n)
    return words, f"{advice}, " if advice else ""


def _strongest(effect: Floats) -> list[int]:
    """Return the modes with an effect worth retaining them, the largest first."""
    (found,) = np.nonzero(effect >= _SMALLEST_EFFECT)
    return [int(mode) for mode in found[np.argsort(-effect[found], kind="stable")]]


def _named(numbers: Sequence[int]) -> str:
    *first, last = map(str, numbers)
    return f"modes {', '.join(first)} and {last}" if first else f"mode {last}"
