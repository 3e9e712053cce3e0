"""From the reduced matrices to a model: its friction table and the harmonics of the contacts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

import numpy as np
from tqdm import tqdm

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.further_harmonics import further_harmonics
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.resolution import (
    Resolution,
    choose_resolution,
    least_force,
    resolved_terms,
)
from slipmode.rom.contact.settled import check_settled
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.contact.torus import ContactTerms, contact_orders, contact_terms
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import SlipmodeError, UnsettledError
from slipmode.rom.laws.friction import Friction, check_law
from slipmode.rom.reduction.combination import (
    CombinationResonance,
    Order,
    combination_resonances,
    tabulated_orders,
)
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.representable import LARGEST_PRODUCT, SMALLEST_PRODUCT
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.corrections import with_detuning, with_rate_correction, with_slope
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.refine import headroom_intervals, refine
from slipmode.rom.table.refinement.sampling import Columns, Sampling
from slipmode.rom.table.region import Region
from slipmode.rom.validity import model_findings, table_findings, warn

_Solved = TypeVar("_Solved")

_STUCK = 1e-6  # contact motion that is rounding, relative to that without friction
_ROUGHLY = 10.0  # how much less well marches repeat for differences of friction
_POINTS_PER_TASK = 16  # fixed, so that the answer does not depend on the number of threads


def tabulate(
    reduced: Reduced,
    law: Friction,
    amplitude: Sequence[float],
    tolerance: float = 1e-3,
    *,
    combinations: Sequence[CombinationResonance] | None = None,
    harmonics: int = 0,
    region: Region | None = None,
    headroom: float = 1.0,
    detuning: bool | None = None,
    threads: int | None = None,
    progress: bool = False,
    warned: bool = True,
) -> Model:
    """Precompute the friction functions over a range of amplitudes.

    Parameters
    ----------
    reduced : Reduced
    law : Tanh or Coulomb
    amplitude : sequence of float
        Largest amplitude |a_j| of each mode [kg^1/2 m].
    tolerance : float
        Of S_j = Q_j |a_j|, relative to its largest value over the table: half of it for the
        contact problem, the whole for the interpolation.
    combinations : sequence of CombinationResonance, optional
        Combination frequencies that the slow flow is to treat as resonant. Default: those near
        the carriers of `reduced`; none in the paper's formulation.
    harmonics : int
        Order up to which harmonics of the contact motion are kept, for the reconstruction of fast
        motion; 0: none. A march needs those that the modes respond to, `RESPONSE_ORDER`.
    region : Region, optional
        Where the table of two modes has to hold; it is not looked up elsewhere. Default:
        everywhere.
    headroom : float
        How far the table goes, relative to `amplitude`, rounded up to eighths: 1 or more, for
        runs that go further than expected. Up to `amplitude` it has the nodes of a table without
        headroom, and more where it needs them beyond. Not with a region.
    detuning : bool, optional
        Whether friction follows the forcing frequencies off the carriers of `reduced`, to first
        order; `Model.accuracy.detuning` says what is left. False where they stay at the
        carriers: it is not looked at. Default: where the carriers are the natural frequencies;
        elsewhere what is left is stated alone. Not in the paper's formulation.
    threads : int, optional
        Default: one per processor. The result does not depend on it.
    progress : bool
        Show a progress bar on work longer than a second.
    warned : bool
        Warn of strained assumptions; a scene has them in its plan instead.

    Raises
    ------
    SlipmodeError
        If the tolerance cannot be reached.

    Warns
    -----
    ValidityWarning
        Where contacts or friction strain what the method assumes, over that range.
    """
    amplitude_range = np.asarray(amplitude, dtype=float)
    if amplitude_range.shape != (len(reduced.modes),) or not np.all(
        (amplitude_range >= SMALLEST_PRODUCT) & (amplitude_range <= LARGEST_PRODUCT)
    ):
        raise SlipmodeError(
            f"amplitude: must be {len(reduced.modes)} finite numbers > 0, "
            f"{SMALLEST_PRODUCT:g} to {LARGEST_PRODUCT:g}, got {amplitude}"
        )
    if not 1e-6 <= tolerance <= 0.1:
        raise SlipmodeError(f"tolerance: must be 1e-6 to 0.1, got {tolerance}")
    if region is not None and not np.array_equal(region.amplitude_range, amplitude_range):
        raise SlipmodeError(
            f"region: must be a part of the same range, got {region.amplitude_range}"
        )
    beyond = headroom_intervals(headroom)
    if beyond and region is not None:
        raise SlipmodeError("headroom: must be 1 where only a region is tabulated")
    check_law(
        reduced.n_contacts, None if reduced.contacts is None else reduced.contacts.reference, law
    )
    if warned:
        warn(model_findings(reduced, law, amplitude_range, combinations or ()))
    if combinations is None:
        combinations = (
            ()
            if reduced.formulation == "paper"
            else combination_resonances(reduced.carrier, even=reduced.even)
        )
    budget = ErrorBudget(tolerance)
    with (
        ThreadPoolExecutor(threads or os.cpu_count()) as pool,
        tqdm(unit=" points", desc="friction table", delay=1.0, disable=not progress) as bar,
    ):
        resolve = partial(
            choose_resolution, reduced, law, amplitude_range, budget, combinations, pool
        )
        resolution = resolve()
        further = further_harmonics(
            *(reduced, law, amplitude_range, resolution.grid, combinations), budget.response
        )

        def refined_on(
            resolution: Resolution, further: Sequence[Order]
        ) -> tuple[list[Order], _Samples, tuple[Table, Table | None, Complexes, float]]:
            orders = contact_orders(reduced, combinations, max(harmonics, 1), further)
            columns = Columns(
                orders=tuple(tabulated_orders(combinations, amplitude_range.size)),
                drives=(*range(amplitude_range.size), *(term.mode for term in combinations)),
                swing=2.0 * reduced.carrier * amplitude_range,
                least=least_force(reduced, amplitude_range),
                loss=_structural_loss(reduced),
                carried=(len(orders) + 1) * reduced.n_contacts if harmonics else 0,
            )
            solve = partial(
                resolved_terms,
                reduced,
                law,
                resolution,
                smallest_scale=0.1 * amplitude_range,
                combinations=combinations,
                highest=max(harmonics, 1),
                further=further,
            )
            check = partial(check_settled, reduced, combinations)
            samples = _Samples(solve, columns, pool, bar, check)
            onset = onset_lines(reduced, law)
            sampling = Sampling(
                *(samples, columns, amplitude_range, onset, budget.march, region, beyond)
            )
            return orders, samples, refine(sampling, budget.interpolation)

        def refined(
            resolution: Resolution, further: Sequence[Order]
        ) -> tuple[list[Order], _Samples, tuple[Table, Table | None, Complexes, float]]:
            found = refined_on(resolution, further)
            if found[-1][-1] <= budget.interpolation or reduced.contacts is None:
                return found
            # where the modes' response is strong, what hardly changes from one period to the next
            # may still be far from where it will settle; rigid contacts are off by the grid
            closer = refined_on(resolution.closer, further)
            return min(found, closer, key=lambda each: each[-1][-1])

        unanswered = 0.0
        off_carriers: float | None = 0.0
        try:
            finer = resolve(list(further)) if further else resolution
            orders, samples, (table, inner, carried, error) = refined(finer, list(further))
            resolution = finer
        except UnsettledError:
            if not further:
                raise
            unanswered = max(further.values())
            orders, samples, (table, inner, carried, error) = refined(resolution, [])
        if reduced.formulation == "consistent":
            spread = partial(_in_tasks, pool)
            answered = [] if unanswered else list(further)

            def solve(march: float, reduced: Reduced, amplitudes: Floats) -> ContactTerms:
                return contact_terms(
                    *(reduced, law, amplitudes, resolution.grid, march, 0.1 * amplitude_range),
                    *(combinations, 1, answered),
                )

            def rated(part: Table) -> Table:
                return with_rate_correction(
                    *(part, reduced, law, amplitude_range, resolution.grid, spread)
                )

            roughly = partial(solve, _ROUGHLY * resolution.march)
            within, off_carriers = rated(table if inner is None else inner), None
            if detuning is None or detuning:
                follows = detuning or np.array_equal(reduced.carrier, reduced.frequency)
                within, off_carriers = with_detuning(
                    *(within, reduced, partial(solve, resolution.march), roughly, spread),
                    tolerance if follows else None,
                )
            if inner is not None:
                table = rated(table)
                if within.detuning is not None:
                    table = with_slope(table, reduced, roughly, spread)
                table = table.keeping(within)
            else:
                table = within
    accuracy = Accuracy(
        tolerance=tolerance,
        interpolation=error,
        resolution=resolution.error,
        periodicity=samples.periodicity,
        unanswered=unanswered,
        detuning=off_carriers,
        steps=resolution.grid.steps,
        lines=resolution.grid.lines,
        solved=samples.solved,
    )
    if warned:
        warn(table_findings(tolerance, error, unanswered))
    kept = _harmonics(table, orders, carried) if harmonics else None
    if reduced.force_patterns is None:
        reduced = replace(
            reduced, contact_motion=_contact_motion(reduced, samples.solve, amplitude_range)
        )
    return Model(reduced, law, table, kept, tuple(combinations), accuracy)


def _harmonics(table: Table, orders: Sequence[Order], carried: Complexes) -> Harmonics:
    """From the columns that samples carried: P of every order, then what they leave out."""
    nodes = tuple(axis.size for axis in table.axes)
    columns = carried.reshape(*nodes, len(orders) + 1, -1)
    P = np.ascontiguousarray(columns[..., :-1, :])
    beyond = np.ascontiguousarray(columns[..., -1, :].real)
    return Harmonics(table.axes, tuple(orders), P, beyond, table.region)


def _contact_motion(
    reduced: Reduced, solve: Callable[[Floats], ContactTerms], amplitude_range: Floats
) -> Complexes:
    """Carriers of the contacts per a_j (modes, N_c) at the largest amplitudes, where they move."""
    moved = (
        solve(amplitude_range[np.newaxis]).P[0, : amplitude_range.size]
        / amplitude_range[:, np.newaxis]
    )
    least = _STUCK * np.linalg.norm(reduced.contact_motion, axis=1, keepdims=True)
    sticks = np.linalg.norm(moved, axis=1, keepdims=True) <= least
    return np.where(sticks, reduced.contact_motion, moved)


def _structural_loss(reduced: Reduced) -> Floats:
    """gamma_j Omega_j, where the contacts share in it; nothing in the paper's formulation.

    Without what aerodynamics put in: contacts have no share in that.
    """
    loss = (reduced.modal_damping - reduced.aerodynamic_damping) * reduced.carrier
    return loss if reduced.formulation == "consistent" else np.zeros_like(loss)


def _in_tasks(
    pool: Executor, solve: Callable[[Floats], _Solved], amplitudes: Floats
) -> Iterator[_Solved]:
    """What `solve` finds at many amplitudes, in tasks of a fixed size on the threads of a pool."""
    starts = range(0, len(amplitudes), _POINTS_PER_TASK)
    if len(starts) == 1:
        return iter([solve(amplitudes)])
    return pool.map(solve, [amplitudes[start : start + _POINTS_PER_TASK] for start in starts])


class _Samples:
    """Contact terms at many amplitudes, spread over threads."""

    def __init__(
        self,
        solve: Callable[[Floats], ContactTerms],
        columns: Columns,
        pool: Executor,
        bar: tqdm[Any],
        check: Callable[[ContactTerms], None],
    ) -> None:
        self.solve = solve
        self._columns = columns
        self._pool = pool
        self._bar = bar
        self._check = check
        self.periodicity = 0.0
        self.solved = 0

    def __call__(self, amplitudes: Floats) -> Complexes:
        parts = []
        for terms in _in_tasks(self._pool, self.solve, amplitudes):
            self._check(terms)
            beyond = np.hstack((terms.P.reshape(len(terms.S), -1), terms.left_out))
            carried = beyond[:, : self._columns.carried]
            lost = (terms.power - terms.leaving)[:, np.newaxis]
            parts.append(np.hstack((terms.S, terms.T, lost, carried)))
            self.periodicity = max(self.periodicity, float(terms.residual.max()))
            self.solved += len(terms.S)
            self._bar.update(len(terms.S))
        return np.concatenate(parts)
