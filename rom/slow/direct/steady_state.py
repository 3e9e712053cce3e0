"""Steady states without a table: for one or a few forcings, and outside the range of tables."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.contact.time_budget import WorkLimit, checked_budget
from slipmode.rom.contact.torus.grid import Discretisation, step_counts
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction, check_law
from slipmode.rom.reduction.combination import Order, harmonic_orders
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.reduction.nonresonant import HIGHEST_HARMONIC, RESPONSE_ORDER
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.direct.forced_balance import (
    CLOSEST,
    LINES,
    Balanced,
    ForcedBalance,
    enough_lines,
)
from slipmode.rom.slow.direct.integrated import ends_soon, integrated
from slipmode.rom.slow.direct.steady_harmonics import SteadyHarmonics, relative_error
from slipmode.rom.structure.structure import Structure
from slipmode.rom.validity import forcing_findings, friction_findings, warn

_HIGHEST = (9, 13, 17)  # |n| + |m| of the harmonics of two modes, in turn
_LEAST_STEPS = {1: 256, 2: 128}  # by modes: at least 8 in a period of the highest harmonic

Method = Literal["balance", "integration"]


@frozen
class SteadyState:
    """Hold a steady state under constant forces F_j cos(Omega_j t).

    Attributes
    ----------
    error : (modes,) ndarray
        Estimated error of `amplitude` due to harmonics, time steps and phase lines [kg^1/2 m]. The
        balance of two modes has an error of at least 0.1 %, because it neglects motion
        between the harmonics.
    harmonics : SteadyHarmonics
        Harmonics of modes and contacts.
    reduced : Reduced
        Reduced structure with the forcing frequencies as carriers.
    force : (modes, n) ndarray
        Force amplitudes F_j [N].
    method : {"balance", "integration"}
        Harmonic balance, or time integration from rest.
    """

    error: Floats
    harmonics: SteadyHarmonics
    reduced: Reduced
    force: Floats
    method: Method

    @property
    def amplitude(self) -> Complexes:
        """Amplitudes a_j of the retained modes at their carriers, (modes,) [kg^1/2 m]."""
        return self.harmonics.amplitude

    @property
    def orders(self) -> list[Order]:
        """Orders (n, m) of the harmonics with the frequencies n Omega_A + m Omega_B."""
        return self.harmonics.orders

    def displacement(self, structure: Structure | None = None) -> Complexes:
        """Return the harmonics of the displacement of all DOFs.

        Parameters
        ----------
        structure : Structure, optional
            Structure that was reduced. Default: the quasi-static response to the forces is
            neglected.

        Returns
        -------
        (orders, n) complex ndarray
            Harmonics c of x = sum 2 Re(c exp(i (n t_A + m t_B))) [m].
        """
        found, reduced = self.harmonics, self.reduced
        x = found.modal @ reduced.all_shapes.T + found.P @ reduced.contact_shapes.T
        if structure is not None:
            static = AppliedForces.of(reduced, list(self.force), structure).static
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
    *,
    budget: float | None = None,
) -> SteadyState:
    """Return the steady state under constant forces, without a friction table.

    For thousands of forcings, `rom.tabulate` and `rom.steady` take less time.

    Parameters
    ----------
    reduced : Reduced
        Reduced structure in the consistent formulation.
    law : contact law
        Tanh or Coulomb for rigid contacts. Otherwise the elastic law that `rom.reduce` received.
    frequency : (modes,) array_like
        Forcing frequencies Omega_j [rad/s].
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes F_j [N], not 0 for any mode.
    tolerance : float, default 0.001
        Error of each amplitude relative to the amplitude itself [-], or to a tenth of the
        strongest mode if that is larger. Modes are compared by their contact motion. 1e-6 to 0.1.
    start : SteadyState, optional
        Steady state nearby as initial guess; the solution stays on its branch. Default: the
        branch reached from rest.
    budget : float, optional
        Limit of the computing time [s]. Default: a limit of the work, see `rom.tabulate`.

    Returns
    -------
    SteadyState
        Amplitudes, harmonics of all DOFs and an error estimate.

    Raises
    ------
    SlipmodeError
        If no steady state is found within the tolerance or the budget, or the motion from rest is
        not periodic in the phases of the forces.

    Warns
    -----
    ValidityWarning
        If a forcing frequency is far from its mode, or friction has hardly any effect.

    Notes
    -----
    One mode is solved by harmonic balance of contacts, modes and forces. Two modes are integrated
    in time from rest. The time step is halved until no amplitude changes by more than the
    tolerance. Harmonic balance also solves two modes whose structural damping needs more than 1000
    periods to end a transient, and all cases with `start`. Where the balance does not converge,
    and for self-excited modes, the motion is integrated. An integration that ends above the
    tolerance states its error.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> state = rom.steady_state(reduced, rom.Coulomb(2.0), [0.98], [{0: 0.15}])
    >>> abs(state.amplitude).round(2), state.method
    (array([3.32]), 'balance')
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
    advice = "a larger tolerance, or one mode" if modes == 2 else "a larger tolerance"
    work = WorkLimit("steady state", advice, checked_budget(budget))
    error, found, method = _solve(reduced, law, f, tolerance, start, work)
    warn(forcing_findings(reduced, Omega, np.ones(modes, dtype=bool)))
    warn(friction_findings(reduced, law, np.abs(found.amplitude)))
    return SteadyState(error, found, reduced, f, method)


def _solve(
    reduced: Reduced,
    law: Friction,
    f: Floats,
    tolerance: float,
    start: SteadyState | None,
    work: WorkLimit,
) -> tuple[Floats, SteadyHarmonics, Method]:
    """Return the error of the amplitudes, the steady state, and how it was found.

    A transient of two modes takes fewer steps than a balance on many phase lines, unless it is
    hardly damped. One mode has one line.
    """
    balance = ForcedBalance(reduced, law, 0.5 * f, tolerance, work)
    if start is not None:
        return *_balanced(balance, start.harmonics), "balance"
    if (reduced.modal_damping < 0.0).any():  # a balance may be unstable
        try:
            return *integrated(reduced, law, f, tolerance, work), "integration"
        except SlipmodeError:
            work.check()
            mode = "AB"[int(np.argmin(reduced.modal_damping))]
            raise SlipmodeError(
                f"aerodynamics: mode {mode} is self-excited, and no steady state was found at the "
                "forcing frequency; rom.limit_cycles finds the limit cycles of a tabulated model"
            ) from None
    if len(reduced.modes) == 1 or not ends_soon(reduced):
        with suppress(SlipmodeError):
            return *_balanced(balance, None), "balance"
    return *integrated(reduced, law, f, tolerance, work), "integration"


def _balanced(
    balance: ForcedBalance, start: SteadyHarmonics | None
) -> tuple[Floats, SteadyHarmonics]:
    """Return the steady state to the tolerance, and the error of its amplitudes."""
    modes, reduced = len(balance.half), balance.reduced
    highest = HIGHEST_HARMONIC[1] if modes == 1 else RESPONSE_ORDER
    orders = harmonic_orders(highest, modes, reduced.even)
    steps, *_, most = step_counts(reduced.carrier, _LEAST_STEPS[modes])
    found = balance.solve(orders, Discretisation(steps, enough_lines(orders)), start)
    by_harmonics = by_lines = np.zeros(modes)
    if modes == 2:
        found, by_harmonics = _with_harmonics(balance, found)
        found, by_lines = _resolved(balance, found, "lines", LINES[-1], 0.5)
    found, by_steps = _resolved(balance, found, "steps", most, 1.0)
    # The rule is of second order for rigid contacts. Elastic contacts that turn between two steps
    # converge irregularly.
    by_steps = by_steps / 3.0 if reduced.contacts is None else by_steps
    # Near resonance the first secants underestimate the distance from the steady state.
    by_iteration = found.off + CLOSEST * balance.tolerance * np.abs(found.amplitude)
    # changes estimate the error by harmonics and grid, but do not bound it
    error = 2.0 * (by_harmonics + by_lines + by_steps) + by_iteration
    if modes == 2:
        # A balance leaves out motion between the harmonics, which changes amplitudes by 8e-4 in
        # test_the_branch_of_two_modes_is_followed_from_a_steady_state.
        error = np.maximum(error, 1e-3 * np.abs(found.amplitude))
    return error, found


def _with_harmonics(balance: ForcedBalance, found: Balanced) -> tuple[Balanced, Floats]:
    """Return the state with all harmonics to which modes respond, and the error by the others."""
    for highest in _HIGHEST:
        more, neglected = balance.responding(found, highest)
        if not more:
            return found, neglected
        orders = [*found.orders, *more]
        grid = replace(found.grid, lines=enough_lines(orders, found.grid.lines))
        finer = balance.solve(orders, grid, found)
        changed, found = np.abs(finer.amplitude - found.amplitude), finer
    return found, changed


def _resolved(
    balance: ForcedBalance,
    found: Balanced,
    name: Literal["steps", "lines"],
    most: int,
    part: float,
) -> tuple[Balanced, Floats]:
    """Return the state on so fine a grid that twice as many "steps" or "lines" hardly change it.

    They change it by less than a part of the tolerance; the change (modes,) is returned too.
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
        f"tolerance: needs more than {most} {name} per period; a tolerance of {2.0 * least:.1g} "
        "is within reach"
    )
