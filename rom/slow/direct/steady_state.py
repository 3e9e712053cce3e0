"""Steady states without a table: for one or a few forcings, and outside the range of tables."""

from __future__ import annotations

from contextlib import suppress
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, check_dof, in_one_line
from slipmode.rom.contact.time_budget import WorkLimit, checked_budget
from slipmode.rom.contact.torus.grid import Discretisation, enough_lines, step_counts
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction, check_law, pulled_at_rest
from slipmode.rom.reduction.combination import Order, harmonic_orders
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.reduction.nonlinear.stiffness import refuse_nonlinear_stiffness
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.direct.forced_balance import CLOSEST, ForcedBalance
from slipmode.rom.slow.direct.integrated import ends_soon, integrated
from slipmode.rom.slow.direct.steady_harmonics import (
    SteadyHarmonics,
    SteadyProblem,
    neglected_modes,
    relative_error,
)
from slipmode.rom.validity import (
    Finding,
    check_carriers,
    forcing_findings,
    friction_findings,
    warn,
)

# By modes, |n| + |m| of the harmonics in turn, with twice the time steps at each level.
_HIGHEST = {1: (7, 15, 31, 63, 127, 127), 2: (7, 11, 17, 25, 25)}
# By modes, the effect of motion between the harmonics of two carriers on the amplitudes: 1.03e-3
# in test_the_branch_of_two_modes_is_followed_from_a_steady_state.
_BETWEEN_HARMONICS = {1: 0.0, 2: 1.2e-3}
_LEAST_STEPS = {1: 256, 2: 128}  # at the first level
_SUDDEN = (
    "contacts have tangential forces at rest, and harmonic balance does not converge. Forces that "
    "grow slowly may end at another amplitude. Try another frequency, or a start nearby"
)

Method = Literal["balance", "integration"]


@frozen
class SteadyState:
    """Hold a steady state under constant forces F_j cos(Omega_j t).

    Attributes
    ----------
    error : (modes,) ndarray
        Estimated error of `amplitude` due to harmonics, time steps, phase lines and modes that
        follow statically [kg^1/2 m], not below the unbalanced force on a finer grid. The balance
        of two modes has an error of at least 0.12 %, because it neglects motion between the
        harmonics.
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

    def displacement(self, dof: int) -> Floats:
        """Return the displacement amplitude of a DOF at each carrier.

        Parameters
        ----------
        dof : int
            Index of the DOF.

        Returns
        -------
        (modes,) ndarray
            Displacement amplitudes [m], with the contacts and the quasi-static response.

        Raises
        ------
        SlipmodeError
            If there is no such DOF.
        """
        check_dof(dof, self.reduced.n_dofs)
        return 2.0 * np.abs(self.displacement_harmonics()[: len(self.force), dof])

    def displacement_harmonics(self) -> Complexes:
        """Return the harmonics of the displacement of all DOFs.

        Returns
        -------
        (orders, n) complex ndarray
            Harmonics c of x = sum 2 Re(c exp(i (n t_A + m t_B))) [m], in the order of `orders`.
        """
        found, reduced = self.harmonics, self.reduced
        x = found.modal @ reduced.all_shapes.T + found.P @ reduced.contact_shapes.T
        applied = AppliedForces(reduced, self.force)
        x[: len(self.force)] += 0.5 * (applied.static * applied.modal).T
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
        If a forcing frequency is far from its mode, or friction has hardly any effect. If contacts
        with tangential forces at rest are integrated: their transient determines the steady state.

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
    reduced.refuse_shared_tone("reduced: must be of one mode, the others respond as well")
    refuse_nonlinear_stiffness(reduced, "rom.steady_state", "use rom.steady with a friction table")
    f = AppliedForces.of(reduced, force).force
    if reduced.formulation == "paper":
        raise SlipmodeError("formulation: must be 'consistent' for a steady state without a table")
    check_law(reduced.n_contacts, reduced.contacts, law)
    Omega = as_floats("frequency", frequency)
    if Omega.shape != (modes,):
        raise SlipmodeError(f"frequency: must be {modes} numbers [rad/s], got {Omega}")
    if reduced.spin is not None:
        check_carriers(reduced, Omega, np.ones(modes, dtype=bool))
    reduced = reduced.at_carrier(Omega.tolist())
    if not f.any(axis=1).all():
        raise SlipmodeError("force: must not be 0; retain the forced modes only (rom.reduce)")
    advice = "a larger tolerance, or one mode" if modes == 2 else "a larger tolerance"
    work = WorkLimit("steady state", advice, checked_budget(budget))
    problem = SteadyProblem(reduced, law, f, tolerance, work)
    error, found, method = _solve(problem, start)
    error = error + neglected_modes(problem, found) * np.abs(found.amplitude)
    warn(forcing_findings(reduced, Omega, np.ones(modes, dtype=bool)))
    warn(friction_findings(reduced, law, np.abs(found.amplitude)))
    if method == "integration" and pulled_at_rest(law, reduced.n_contacts):
        warn([Finding("load history", "of forces that begin suddenly", _SUDDEN, "warning")])
    return SteadyState(error, found, reduced, f, method)


def _solve(
    problem: SteadyProblem, start: SteadyState | None
) -> tuple[Floats, SteadyHarmonics, Method]:
    """Return the error of the amplitudes, the steady state, and how it was found.

    A transient of two modes takes fewer steps than a balance on many phase lines, unless it is
    hardly damped. One mode has one line.
    """
    reduced = problem.reduced
    if start is not None:
        return *_balanced(problem, start.harmonics), "balance"
    if (reduced.modal_damping < 0.0).any():  # a balance may be unstable
        try:
            return *integrated(problem), "integration"
        except SlipmodeError:
            problem.work.check()
            mode = "AB"[int(np.argmin(reduced.modal_damping))]
            raise SlipmodeError(
                f"aerodynamics: mode {mode} is self-excited, and no steady state was found at the "
                "forcing frequency; rom.limit_cycles finds the limit cycles of a tabulated model"
            ) from None
    if len(reduced.modes) == 1 or not ends_soon(reduced):
        with suppress(SlipmodeError):
            return *_balanced(problem, None), "balance"
    return *integrated(problem), "integration"


def _balanced(
    problem: SteadyProblem, start: SteadyHarmonics | None
) -> tuple[Floats, SteadyHarmonics]:
    """Return the steady state to the tolerance, and the error of its amplitudes.

    The state of each level is put into the equations of the next level, with more harmonics, steps
    and phase lines, and corrected there. The last correction is the error: the error of the
    corrected state is smaller by the order of the time steps.
    """
    reduced, tolerance, modes = problem.reduced, problem.tolerance, len(problem.force)
    steps, *_, most = step_counts(reduced.carrier, _LEAST_STEPS[modes])
    levels = []
    for number, highest in enumerate(_HIGHEST[modes]):
        orders = tuple(harmonic_orders(highest, modes, reduced.even))
        grid = Discretisation(min(steps << number, most), enough_lines(orders))
        levels.append(ForcedBalance(problem, orders, grid))
    found, error = levels[0].solve(start), np.zeros(modes)
    for level, finer in pairwise(levels[1:]):
        before, found = found.amplitude, level.solve(found)
        # Effects of harmonics and steps may cancel by chance: the error of second order is not
        # below a quarter of the error before.
        error = np.maximum(np.abs(found.amplitude - before), 0.25 * error)
        off = relative_error(reduced, error, found.amplitude)
        if off > tolerance:
            continue
        residual, full = finer.checked(found)
        size = np.abs(found.amplitude)
        stated = np.maximum(error, residual * size) + CLOSEST * tolerance * size
        off = relative_error(reduced, stated, found.amplitude) / (1.0 + CLOSEST)
        if off <= tolerance:
            return np.maximum(stated, _BETWEEN_HARMONICS[modes] * size), full
    raise SlipmodeError(
        f"tolerance: needs more than {level.grid.steps} steps per period; a tolerance of "
        f"{2.0 * off:.1g} is within reach"
    )
