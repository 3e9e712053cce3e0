"""Steady states without a table: for one or a few forcings, and where a table has no answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.contact.torus.grid import Discretisation, step_counts
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction, check_law
from slipmode.rom.reduction.combination import Order, harmonic_orders
from slipmode.rom.reduction.force_response import AppliedForces, ForceResponse, Forces
from slipmode.rom.reduction.nonresonant import HIGHEST_HARMONIC, RESPONSE_ORDER
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.direct.forced_balance import (
    CLOSEST,
    LINES,
    Balanced,
    Effort,
    ForcedBalance,
    enough_lines,
)
from slipmode.rom.slow.direct.integrated import integrated, integration_effort, settles_soon
from slipmode.rom.slow.direct.steady_harmonics import SteadyHarmonics, relative_error
from slipmode.rom.structure.structure import Structure
from slipmode.rom.validity import forcing_findings, friction_findings, warn

_HIGHEST = {1: (13, 31), 2: (9, 13, 17)}  # |n| + |m| of harmonics, by modes
_LEAST_STEPS = {1: 256, 2: 128}  # at least 8 in a period of the highest harmonic
_SAFETY = 2.0
_LEFT_BY_STEPS = 1 / 3  # of the change by twice as many: they are of second order
# What is led, and first steps (`ForcedBalance`): which of them settle depends on little, most
# often the first do.
_TRIES = ((0.0, 0.1), (1.0, 0.1), (0.0, 0.02), (0.0, 0.3))
# Relative distances of the frequencies from which a steady state is followed if no try converges
# from rest; needed by test_nlvib_example_08_has_answers_where_a_mode_is_near_the_seventh_harmonic.
_BESIDE = (-1e-3, 1e-3, 3e-4)

Method = Literal["balance", "integration"]


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A steady state under constant forces F_j cos(Omega_j t).

    Attributes
    ----------
    error : (modes,) ndarray
        Estimate of what harmonics, time steps and phase lines leave of `amplitude` [kg^1/2 m].
    harmonics : SteadyHarmonics
    reduced : Reduced
        At these frequencies.
    force : (modes, n) ndarray
        [N]
    method : {"balance", "integration"}
        Of harmonics, or in time from rest.
    """

    error: Floats
    harmonics: SteadyHarmonics
    reduced: Reduced
    force: Floats
    method: Method

    __repr__ = short_repr

    @property
    def amplitude(self) -> Complexes:
        """a_j of the retained modes at their carriers, (modes,) [kg^1/2 m]."""
        return self.harmonics.amplitude

    @property
    def orders(self) -> list[Order]:
        """Harmonics (n, m), frequency n Omega_A + m Omega_B."""
        return self.harmonics.orders

    def displacement(self, structure: Structure | None = None) -> Complexes:
        """Harmonics c of all DOFs, x = sum 2 Re(c exp(i (n t_A + m t_B))), (orders, n) [m].

        Without the structure they lack what the forces do statically past modes and contacts.
        """
        found, reduced = self.harmonics, self.reduced
        x = found.modal @ reduced.all_shapes.T + found.P @ reduced.contact_shapes.T
        if structure is not None:
            static = ForceResponse.of(reduced, list(self.force), structure).static
            own = [reduced.modal_force(j, f) for j, f in enumerate(self.force)]
            x[: len(self.force)] += 0.5 * (static * own).T
        return np.asarray(x)


def steady_state(
    reduced: Reduced,
    law: Friction,
    frequency: ArrayLike,
    force: Forces,
    tolerance: float = 1e-3,
    start: SteadyState | None = None,
) -> SteadyState:
    """Solve for the steady state under constant forces, without a table.

    With two modes the motion is integrated in time from rest, in finer and finer steps until the
    amplitudes change by less than the tolerance. With one, from a `start`, or where structural
    damping would take thousands of periods to end a transient, contacts and modes are brought
    into balance at harmonics; where that finds nothing, elastic contacts are integrated after
    all. Where integration ends above the tolerance, it states its error.
    Where thousands of forcings are asked for, `steady` looks them up in a table.

    Parameters
    ----------
    reduced : Reduced
        In the consistent formulation.
    law : Friction
        Of its contacts; elastic ones are those it was reduced with.
    frequency : (modes,) array_like
        Forcing frequencies [rad/s], wherever the modes of `reduced` respond to them.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes F_j [N].
    tolerance : float
        Relative to each amplitude, or to a tenth of the largest where a mode is weaker than that
        (by the contact motion that they bring).
    start : SteadyState, optional
        Near by: its branch is followed. Default: the branch reached from rest.

    Raises
    ------
    SlipmodeError
        If no steady state is found, or none to the tolerance; if the motion from rest is not
        periodic in the phases of the forces.

    Warns
    -----
    ValidityWarning
        Where a forcing frequency is far from its mode, or friction does nothing or hardly acts.
    """
    if not 1e-6 <= as_floats("tolerance", tolerance) <= 0.1:
        raise SlipmodeError(f"tolerance: must be 1e-6 to 0.1, got {tolerance}")
    if start is not None and not isinstance(start, SteadyState):
        raise SlipmodeError(f"start: must be a SteadyState, got {in_one_line(start)}")
    modes = len(reduced.modes)
    f = AppliedForces.of(reduced, force).force
    if reduced.formulation == "paper":
        raise SlipmodeError("formulation: must be 'consistent' for a steady state without a table")
    reference = None if reduced.contacts is None else reduced.contacts.reference
    check_law(reduced.n_contacts, reference, law)
    Omega = as_floats("frequency", frequency)
    if Omega.shape != (modes,):
        raise SlipmodeError(f"frequency: must be {modes} numbers [rad/s], got {Omega}")
    reduced = reduced.at_carrier(Omega.tolist())
    if not f.any(axis=1).all():
        raise SlipmodeError("force: must not be 0; retain the forced modes only (rom.reduce)")
    error, found, method = _found(reduced, law, f, tolerance, start)
    warn(forcing_findings(reduced, Omega, np.ones(modes, dtype=bool)))
    warn(friction_findings(reduced, law, np.abs(found.amplitude)))
    return SteadyState(error, found, reduced, f, method)


def _found(
    reduced: Reduced, law: Friction, f: Floats, tolerance: float, start: SteadyState | None
) -> tuple[Floats, SteadyHarmonics, Method]:
    """The error of its amplitudes, the steady state, and how it was found.

    A transient of two modes takes fewer steps than a search for harmonics on many phase lines,
    unless next to nothing damps it; of one mode there is one line.
    """
    if start is not None:
        effort = Effort(np.inf)
        return *_settled(reduced, law, f, tolerance, effort, start.harmonics), "balance"
    elastic = reduced.contacts is not None
    effort = Effort(integration_effort(reduced) if elastic else np.inf)
    if len(reduced.modes) == 2 and settles_soon(reduced):
        try:
            return *integrated(reduced, law, f, tolerance), "integration"
        except SlipmodeError as refusal:
            return *_balanced(reduced, law, f, tolerance, effort, refusal), "balance"
    if not elastic:
        return *_balanced(reduced, law, f, tolerance, effort), "balance"
    try:
        return *_settled(reduced, law, f, tolerance, effort, None), "balance"
    except SlipmodeError:
        return *integrated(reduced, law, f, tolerance), "integration"


def _balanced(
    reduced: Reduced,
    law: Friction,
    f: Floats,
    tolerance: float,
    effort: Effort,
    refusal: SlipmodeError | None = None,
) -> tuple[Floats, Balanced]:
    """From rest, or from beside; `refusal` is raised where there is none, or the search's own."""
    try:
        return _settled(reduced, law, f, tolerance, effort, None)
    except SlipmodeError as own:
        beside = _from_beside(reduced, law, f, tolerance, effort)
        if beside is None:
            raise (refusal or own) from None
        return beside


def _from_beside(
    reduced: Reduced, law: Friction, f: Floats, tolerance: float, effort: Effort
) -> tuple[Floats, Balanced] | None:
    """Followed from frequencies beside these; None if that settles no better.

    Where a harmonic meets a mode, which searches settle is as good as random from one frequency
    to the next: an answer that is close by already settles most often.
    """
    for part in _BESIDE:
        beside = reduced.at_carrier(((1.0 + part) * np.array(reduced.carrier)).tolist())
        try:
            _, near = _settled(beside, law, f, tolerance, effort, None)
            return _settled(reduced, law, f, tolerance, effort, near)
        except SlipmodeError:
            continue
    return None


def _settled(
    reduced: Reduced,
    law: Friction,
    f: Floats,
    tolerance: float,
    effort: Effort,
    begin: SteadyHarmonics | None,
) -> tuple[Floats, Balanced]:
    """By the first of several tries that settles."""
    for led, first_step in _TRIES:
        balance = ForcedBalance(reduced, law, 0.5 * f, tolerance, effort, led, first_step)
        try:
            return _solved(balance, begin)
        except SlipmodeError as refusal:
            last = refusal
            if effort.left < 0.0:
                break
    raise last


def _solved(balance: ForcedBalance, begin: SteadyHarmonics | None) -> tuple[Floats, Balanced]:
    """The steady state to the tolerance, and the error of its amplitudes."""
    modes = len(balance.half)
    highest = HIGHEST_HARMONIC[1] if modes == 1 else RESPONSE_ORDER
    orders = harmonic_orders(highest, modes, balance.reduced.even)
    steps, *_, most = step_counts(balance.reduced.carrier, _LEAST_STEPS[modes])
    found = balance.solve(orders, Discretisation(steps, enough_lines(orders)), begin)
    by_harmonics = np.zeros(modes)
    if modes == 2:
        found, by_harmonics = _with_harmonics(balance, found)
    by_grid = np.zeros(modes)
    if modes == 2:
        found, by_grid = _resolved(balance, found, "lines", LINES[-1], 0.5)
    found, by_steps = _resolved(balance, found, "steps", most, 1.0)
    # what changes tell is no bound; elastic contacts that turn between two steps settle slowly
    left = _LEFT_BY_STEPS if balance.reduced.contacts is None else 1.0
    # Near resonance the first secants underestimate the distance from the steady state.
    by_iteration = found.off + CLOSEST * balance.tolerance * np.abs(found.amplitude)
    return _SAFETY * (by_harmonics + by_grid + left * by_steps) + by_iteration, found


def _with_harmonics(balance: ForcedBalance, found: Balanced) -> tuple[Balanced, Floats]:
    """With all harmonics that modes respond to, and the error by the others."""
    changed = np.zeros(found.amplitude.size)
    for highest in _HIGHEST[found.amplitude.size]:
        wanted, left = balance.responding(found, highest)
        if not wanted:
            return found, left
        orders = [*found.orders, *wanted]
        grid = replace(found.grid, lines=enough_lines(orders, found.grid.lines))
        finer = balance.solve(orders, grid, found)
        changed, found = np.abs(finer.amplitude - found.amplitude), finer
    return found, changed


def _resolved(
    balance: ForcedBalance, found: Balanced, name: str, most: int, part: float
) -> tuple[Balanced, Floats]:
    """With so many "steps" or "lines" that twice as many change less than a part of the tolerance.

    Of `most` at most; and that change.
    """
    least = np.inf
    while 2 * getattr(found.grid, name) <= most:
        grid = replace(found.grid, **{name: 2 * getattr(found.grid, name)})
        finer = balance.solve(found.orders, grid, found)
        changed, found = np.abs(finer.amplitude - found.amplitude), finer
        least = min(least, relative_error(balance.reduced, changed, found.amplitude))
        if least <= part * balance.tolerance:
            return found, changed
    raise SlipmodeError(
        f"tolerance: needs more than {most} {name} per period; {2.0 * least:.1g} is within reach"
    )
