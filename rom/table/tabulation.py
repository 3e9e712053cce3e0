"""From the reduced matrices to a model: its friction table and the harmonics of the contacts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple, overload

import numpy as np

from slipmode.rom.arrays import Complexes, Floats, as_floats, check_count
from slipmode.rom.contact.detuning import MOST_DETUNING
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.resolution import Mapped, Resolution, ResolutionSearch
from slipmode.rom.contact.time_budget import TimeBudget, WorkLimit, checked_budget
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import SlipmodeError, UnsettledError
from slipmode.rom.laws.friction import Friction, check_law
from slipmode.rom.progress import progress_bar
from slipmode.rom.reduction.combination import CombinationResonance, Order
from slipmode.rom.reduction.nonlinear.stiffness import check_amplitude_range
from slipmode.rom.reduction.reduction import Reduced
from slipmode.rom.reduction.tones import combinations_along
from slipmode.rom.representable import LARGEST_PRODUCT, SMALLEST_PRODUCT
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.candidates import Candidate, candidates
from slipmode.rom.table.corrections import with_detuning, with_rate_correction
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.refine import refine
from slipmode.rom.table.refinement.sampling import ContactSamples, Sampling
from slipmode.rom.validity import check_table_carriers, model_findings, warn


@overload
def tabulate(
    reduced: Reduced,
    law: Friction,
    amplitude: Sequence[float],
    tolerance: float = 1e-3,
    *,
    combinations: Sequence[CombinationResonance] | None = None,
    harmonics: int = 0,
    headroom: float = 1.0,
    detuning: bool | float | None = None,
    budget: float | None = None,
    threads: int | None = None,
    progress: bool = False,
    warned: bool = True,
) -> Model: ...


@overload
def tabulate(
    reduced: Reduced, law: Friction, amplitude: None = None, tolerance: float = 1e-3
) -> ToneModel: ...


def tabulate(
    reduced: Reduced,
    law: Friction,
    amplitude: Sequence[float] | None = None,
    tolerance: float = 1e-3,
    *,
    combinations: Sequence[CombinationResonance] | None = None,
    harmonics: int = 0,
    headroom: float = 1.0,
    detuning: bool | float | None = None,
    budget: float | None = None,
    threads: int | None = None,
    progress: bool = False,
    warned: bool = True,
) -> Model | ToneModel:
    """Return a model with the friction terms S_j tabulated over the amplitude plane.

    The contact problem is solved at nodes |a_A|, |a_B| on the torus of both phases, source
    Eqs. (13), (14) and (20). Nodes are added until the interpolation meets the tolerance.

    Parameters
    ----------
    reduced : Reduced
        Reduced structure from `rom.reduce`. Its carriers are the reference frequencies of the
        table.
    law : contact law
        Tanh or Coulomb if `reduced` has rigid contacts. Otherwise the elastic law that
        `rom.reduce` received, or an elastic law with equal stiffness in stick.
    amplitude : sequence of float
        Largest amplitude |a_j| of each mode [kg^1/2 m]. With a `ratio` of carriers one for
        A suffices; B then moves the contacts at most as A does. It is left out, as all that
        follows the tolerance, if the modes share a carrier: their friction is tabulated contact
        by contact, for any amplitude.
    tolerance : float, default 0.001
        Relative error of the amplitude equation [-], see Notes.
    combinations : sequence of CombinationResonance, optional
        Harmonics that drive the slow flow. Default: the combination resonances near the carriers
        of `reduced`; none in the formulation "paper".
    harmonics : int, default 0
        Largest order |n| + |m| of the harmonics of the contact motion that the model stores for
        fast motion. 0 stores none. `rom.sum_harmonics` needs them, for instance up to 7. With them
        `rom.reconstruct` includes the response of the modes to the harmonics.
    headroom : float, default 1.0
        Margin of the amplitude range: the table ends at `headroom` times `amplitude` [-], >= 1.
    detuning : bool or float, optional
        A number: friction depends on the forcing frequencies to first order about the carriers,
        up to this relative distance from them [-], > 0 and at most 0.05; a smaller distance has a
        smaller error. True: 0.05. False: this dependence is neglected and its error is not
        estimated. Default: True where the carriers are the natural frequencies; otherwise only
        the error is estimated. `Accuracy.detuning` states the remaining error. Not available in
        the formulation "paper".
    budget : float, optional
        Approximate limit of the computing time [s]. Default: a limit of the work, one to five
        minutes on one processor, which does not depend on the load of the machine.
    threads : int, optional
        Number of threads, without effect on the result. Default: one for each processor.
    progress : bool, default False
        Show a progress bar if the computation takes longer than 1 s.
    warned : bool, default True
        Warn of violated assumptions. A scene reports them in its plan instead.

    Returns
    -------
    Model or ToneModel
        Reduced structure and friction table, with the measured errors in `Model.accuracy`;
        `ToneModel` if the modes share a tone.

    Raises
    ------
    SlipmodeError
        If an argument is outside its range, or the law does not fit `reduced`. If the tolerance
        cannot be reached, or not within the budget; the message then states what is possible.
        If a carrier is below 0.62 or above 10 times the natural frequency of its mode.

    Warns
    -----
    ValidityWarning
        If contacts or friction violate an assumption within the amplitude range, a carrier is far
        from its mode, or the table misses its tolerance.

    Notes
    -----
    Errors of S_j are relative to |S_j| + gamma_j Omega_j |a_j|, friction and structural damping
    together, at amplitudes above 1e-3 of the range. Frequency and damping of a backbone
    have this accuracy. With two modes the scale is at least the largest |S_j| times
    rho = max_k |a_k| / range_k. See "Friction functions" in docs/theory.md.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), carrier=(0.98, 1.65))
    >>> model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(4.0, 2.0), tolerance=0.01)
    >>> abs(rom.steady(model, (0.98, 1.65), [{0: 0.15}, {1: 0.15}])).round(2)
    array([3.19, 0.53])
    """
    if amplitude is None:
        if not reduced.shares_tone:
            raise SlipmodeError("amplitude: is missing; give the largest amplitude of each mode")
        if (combinations, harmonics, headroom, detuning, budget) != (None, 0, 1.0, None, None):
            raise SlipmodeError(
                "tabulate: modes that share a tone have tables by contact, without combinations, "
                "harmonics, headroom, detuning and budget; leave these out"
            )
        return ToneModel.of(reduced, law, tolerance)
    if reduced.shares_tone:
        reduced.refuse_shared_tone("amplitude: must be left out")
    ends = extended_range(_of_both(reduced, amplitude), headroom)
    check_request(ends, len(reduced.modes), tolerance, amplitude)
    distance = _checked_distance(detuning)
    time_budget, shares = TimeBudget(checked_budget(budget) or np.inf), ErrorBudget(tolerance)
    if threads is not None:
        check_count("threads", threads)
    check_law(reduced.n_contacts, reduced.contacts, law)
    check_table_carriers(reduced.frequency, reduced.carrier)
    check_amplitude_range(reduced, ends)
    if warned:
        warn(model_findings(reduced, law, ends, combinations or ()))
    if combinations is None:
        consistent = reduced.formulation == "consistent"
        combinations = combinations_along(reduced, reduced.carrier) if consistent else ()
    # with a budget in seconds the message says what is possible in this time
    work = WorkLimit("friction table", _advice(len(reduced.modes))) if budget is None else None
    problem = replace(ContactProblem.of(reduced, law, combinations), work=work)
    # Samples of sliders begin with those nearby. Not under varying load, where contacts may
    # have two motions.
    carries = harmonics > 0 or (reduced.contacts is not None and not reduced.even)
    with (
        ThreadPoolExecutor(threads or os.cpu_count()) as pool,
        progress_bar(unit=" points", desc="friction table", delay=1.0, shown=progress) as bar,
    ):
        # Of one mode and few contacts, threads would take longer to start than they save.
        quick = len(reduced.modes) == 1 and reduced.n_contacts <= 8
        mapped: Mapped = map if quick else pool.map
        tables: list[_Tabulated] = []
        for candidate in candidates(problem, ends, tolerance):
            search = ResolutionSearch(
                candidate.problem, ends, shares, mapped, time_budget, not candidate.is_simplest
            )
            requesting = candidate.problem.requesting(max(harmonics, 1))
            allowed, own = candidate.allowed * shares.interpolation, []
            try:
                resolution = search.choose()
                for each in (resolution, resolution.finer):
                    torus = requesting.on(each.grid, each.march, smallest_scale(reduced, ends))
                    samples = ContactSamples(torus, ends, mapped, bar, carries)
                    sampling = Sampling(samples, requesting, ends, shares.march, harmonics > 0)
                    made = refine(sampling, allowed, time_budget)
                    own.append(_Tabulated(candidate, each, samples, *made))
                    if not _is_finer_worth(reduced, own[0].error / allowed):
                        break
            except UnsettledError:
                if candidate.is_simplest and not tables:
                    raise
                continue
            tables.append(min(own, key=lambda each: each.error))
            # Without harmonics that change S_j little the motion may repeat less well
            # (test_of_elastic_contacts): then those with them are tried as well.
            if candidate.allowed == 1.0 or tables[-1].error <= tolerance:
                break
        found = min(tables, key=lambda each: each.error + each.candidate.neglected_response)
        table, off_carriers = _corrected(found, tolerance, detuning, distance, mapped)
    torus = found.samples.torus
    reduced = torus.problem.reduced
    accuracy = Accuracy(
        tolerance=tolerance,
        interpolation=found.error,
        resolution=found.resolution.error,
        periodicity=found.samples.periodicity,
        neglected_response=found.candidate.neglected_response,
        neglected_modes=found.candidate.neglected_modes,
        detuning=off_carriers,
        steps=torus.grid.steps,
        lines=torus.grid.lines,
        solved=found.samples.solved,
        distance=distance,
    )
    if warned:
        warn(accuracy.findings())
    carried = found.carried
    kept = None if carried is None else _harmonics(table, torus.problem.orders, carried)
    if reduced.force_patterns is None:
        moved = _contact_motion(reduced, found.samples.carriers / ends[:, np.newaxis])
        reduced = reduced.moving(moved)
    return Model(reduced, law, table, kept, tuple(combinations), accuracy)


class _Tabulated(NamedTuple):
    """A table, the samples behind it, and its errors; see `refine`."""

    candidate: Candidate
    resolution: Resolution
    samples: ContactSamples
    table: Table
    carried: Complexes | None
    error: float


def _corrected(
    found: _Tabulated,
    tolerance: float,
    detuning: bool | float | None,
    distance: float,
    mapped: Mapped,
) -> tuple[Table, float | None]:
    """Return the table with its corrections, and the error of forcing off the carriers.

    The rate correction, and dS_j / dOmega_k where that reduces the error at `distance`.
    """
    torus, reduced = found.samples.torus, found.samples.torus.problem.reduced
    if reduced.formulation == "paper":
        return found.table, 0.0
    table = with_rate_correction(found.table, torus, tolerance, mapped)
    if detuning is not None and not detuning:
        return table, None
    own = slice(reduced.tones)  # the others follow
    is_wanted = detuning or np.array_equal(reduced.carrier[own], reduced.frequency[own])
    return with_detuning(table, torus, mapped, tolerance if is_wanted else None, distance)


def _is_finer_worth(reduced: Reduced, share: float) -> bool:
    """Return whether a table with an error of this share of its tolerance is made in finer steps.

    At the onset of slip steps may be too long, and of two motions that contacts may come to, other
    steps may find one. Of elastic contacts, errors up to twice the tolerance are stated instead,
    as a finer table takes four times as long; so are errors of two modes, where it would take
    minutes. Errors of more than four times the tolerance are jumps of friction.
    """
    stated = 1.0 if reduced.contacts is None else 2.0
    return len(reduced.modes) == 1 and stated < share <= 4.0


def _checked_distance(detuning: bool | float | None) -> float:
    """Return the largest relative distance from the carriers [-]; refuse one that is too large."""
    is_flag = detuning is None or isinstance(detuning, bool | np.bool_)
    distance = MOST_DETUNING if is_flag else float(as_floats("detuning", detuning))
    if not 0.0 < distance <= MOST_DETUNING:
        raise SlipmodeError(
            f"detuning: must be True, False, or a number > 0 and <= {MOST_DETUNING:g}, "
            f"got {detuning}"
        )
    return distance


def _of_both(reduced: Reduced, amplitude: Sequence[float]) -> Sequence[float]:
    """Return the largest amplitudes of all modes, of which a second one on a tone may be missing.

    The contacts that mode A moves limit it: they drive it, and damp it.
    """
    if not reduced.ratio or np.shape(amplitude) != (1,):
        return amplitude
    moves = np.linalg.norm(reduced.coupling, axis=1)
    return [amplitude[0], amplitude[0] * float(moves[0] / moves[1])]


def _advice(modes: int) -> str:
    """Return what makes a table of so many modes cheaper."""
    fewer = ", one mode" if modes == 2 else ""
    return f"a larger tolerance, smaller amplitudes{fewer}, or fewer contacts or sliders"


@frozen
class ProblemTable:
    """Hold the friction table of a contact problem, and the contact motion at its nodes.

    Attributes
    ----------
    table : Table
        Friction terms S_j over the amplitudes, with their corrections. The power is 0.
    carriers : (n_a, [n_b,] modes, N_c) complex ndarray
        Harmonics P of the contacts at the carriers at the nodes: force deficits of elastic
        contacts [N], displacements of rigid contacts [m].
    accuracy : Accuracy
        Measured errors of the table.
    """

    table: Table
    carriers: Complexes
    accuracy: Accuracy


def tabulate_problem(
    problem: ContactProblem, amplitude: Sequence[float], tolerance: float
) -> ProblemTable:
    """Return the friction table of a contact problem.

    Parameters
    ----------
    problem : ContactProblem
        Contact problem of one or two modes without combination resonances.
    amplitude : sequence of float
        Largest amplitude |a_j| of each mode [kg^1/2 m].
    tolerance : float
        Relative error of the amplitude equation [-], as in `rom.tabulate`.

    Returns
    -------
    ProblemTable
        Table, contact motion at its nodes, and errors.

    Raises
    ------
    SlipmodeError
        If an amplitude or the tolerance is outside its range, or the tolerance cannot be reached.
    UnsettledError
        If no periodic contact motion is found.
    """
    reduced, ends = problem.reduced, as_floats("amplitude", amplitude)
    modes = len(reduced.modes)
    check_request(ends, modes, tolerance, amplitude)
    budget, forever, residuals = ErrorBudget(tolerance), TimeBudget(np.inf), [0.0]

    def sample(amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        terms = torus.solve(amplitudes)
        terms.check_periodic()
        residuals.extend(terms.residual)
        at_carriers = terms.P[:, :modes].reshape(len(amplitudes), -1)
        return np.hstack((terms.S, np.zeros((len(amplitudes), 1)), at_carriers))

    resolution = ResolutionSearch(problem, ends, budget, map, forever).choose()
    torus = problem.on(resolution.grid, resolution.march, smallest_scale(reduced, ends))
    sampling = Sampling(sample, problem, ends, budget.march, kept=True)
    table, carriers, error = refine(sampling, budget.interpolation, forever)
    assert carriers is not None  # `kept`
    table = with_rate_correction(table, torus, tolerance, map)
    detuning = None
    if modes == 1:
        table, detuning = with_detuning(table, torus, map, tolerance, MOST_DETUNING)
    accuracy = Accuracy(
        tolerance,
        error,
        resolution.error,
        periodicity=float(max(residuals)),
        detuning=detuning,
        steps=resolution.grid.steps,
        lines=resolution.grid.lines,
        solved=len(residuals) - 1,
    )
    nodes = tuple(axis.size for axis in table.axes)
    return ProblemTable(table, carriers.reshape(*nodes, modes, -1), accuracy)


def extended_range(amplitude: Sequence[float], headroom: float) -> Floats:
    """Return the largest amplitudes (modes,) of a table that ends at `headroom` times `amplitude`.

    Raises
    ------
    SlipmodeError
        If `headroom` is not a finite number of at least 1.
    """
    if not (np.isfinite(headroom) and headroom >= 1.0):
        raise SlipmodeError(f"headroom: must be a finite number >= 1, got {headroom:g}")
    return headroom * np.asarray(amplitude, dtype=float)


def check_request(
    amplitude_range: Floats, modes: int, tolerance: float, amplitude: Sequence[float]
) -> None:
    """Refuse a range (modes,) or a tolerance that no table has; `amplitude` is as it was given."""
    if amplitude_range.shape != (modes,) or not np.all(
        (amplitude_range >= SMALLEST_PRODUCT) & (amplitude_range <= LARGEST_PRODUCT)
    ):
        raise SlipmodeError(
            f"amplitude: must be {modes} finite numbers > 0, "
            f"{SMALLEST_PRODUCT:g} to {LARGEST_PRODUCT:g}, got {amplitude}"
        )
    if not 1e-6 <= tolerance <= 0.1:
        raise SlipmodeError(f"tolerance: must be 1e-6 to 0.1, got {tolerance}")


def _harmonics(table: Table, orders: Sequence[Order], carried: Complexes) -> Harmonics:
    """From the columns that samples carried: P of every order, then what they leave out."""
    nodes = tuple(axis.size for axis in table.axes)
    columns = carried.reshape(*nodes, len(orders) + 1, -1)
    P = np.ascontiguousarray(columns[..., :-1, :])
    beyond = np.ascontiguousarray(columns[..., -1, :].real)
    return Harmonics(table.axes, tuple(orders), P, beyond)


def _contact_motion(reduced: Reduced, moved: Complexes) -> Complexes:
    """Carriers of the contacts per a_j (modes, N_c) at the largest amplitudes, where they move."""
    rounding = 1e-6 * np.linalg.norm(reduced.contact_motion, axis=1, keepdims=True)
    sticks = np.linalg.norm(moved, axis=1, keepdims=True) <= rounding
    return np.where(sticks, reduced.contact_motion, moved)
