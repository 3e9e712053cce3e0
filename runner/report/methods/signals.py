"""Speed against error on whole signals from rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.rom.full import FullMotion
from slipmode.rom.full.integration import Integrator
from slipmode.rom.reduction.reduction import Formulation
from slipmode.rom.slow.motion import Motion
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.cases import SAMPLING, Case
from slipmode.runner.report.measure import OURS, Row, Section, relative_rms, timed
from slipmode.runner.report.methods.ours import Marcher, SlowCase
from slipmode.runner.report.peers.first_order import FirstOrder, Integrate

ERRORS = ("x", "x_c in window", "energy")
SLOW = f"{OURS}, slow flow"
_MOTIONS = (f"{OURS}, motion", f"{OURS}, sums")
_REFERENCE_REFINEMENT = 64
_LARGE = 20  # DOFs from which a quarter of that has to do


@dataclass(frozen=True, eq=False)
class Reference:
    """Converged signals of a case.

    Attributes
    ----------
    case : Case
    motion : FullMotion
        With the observed DOFs as outputs.
    error : float
        Its own estimate, of the worst observed displacement.
    """

    case: Case
    motion: FullMotion
    error: float

    @classmethod
    def of(cls, case: Case) -> Reference:
        """Integrate at a small step, and at half of it."""
        is_large = case.structure.n_dofs > _LARGE
        step = SAMPLING / _REFERENCE_REFINEMENT * (4 if is_large else 1)
        found = full.converged(
            *(case.structure, case.law, case.excitation, case.times),
            step=step,
            outputs=case.observed,
        )
        return cls(case, found.motion, float(found.displacement_error.max()))

    def errors(
        self, x: Floats, x_c: Floats, energy: float = float("nan")
    ) -> tuple[float, float, float]:
        """Errors of displacements (samples, observed), contacts (samples, N_c) and energy [J]."""
        window = self.case.in_window
        return (
            relative_rms(x, self.motion.displacement),
            relative_rms(x_c[window], self.motion.contact_displacement[window]),
            abs(energy / float(self.motion.dissipated[-1]) - 1.0),
        )


def slow_rows(
    reference: Reference,
    tolerances: Sequence[float],
    steps: Sequence[tuple[float, float]],
    formulation: Formulation = "consistent",
) -> Iterator[Row]:
    """Our rows: the slow flow at several table tolerances, communication steps and tolerances.

    The finest of the tables also has the fast motion computed, over the window and throughout.
    """
    method = OURS if formulation == "consistent" else "paper formulation"
    for tolerance in tolerances:
        slow = SlowCase.tabulate(reference.case, tolerance, formulation)
        for step, flow in steps:
            setting = slow_setting(tolerance, step, flow)
            march = slow.march(step, flow)
            yield slow_row(reference, slow, march, f"{method}, slow flow", setting)
    yield from _motion_rows(reference, slow, method, f"table {tolerance:g}")


def slow_row(
    reference: Reference, slow: SlowCase, march: Marcher, method: str, setting: str
) -> Row:
    """Timed: the amplitudes. The errors are those of the motion that they stand for."""
    seconds, outputs = timed(march, 9)
    motion = march.motion(outputs, reference.case.times)
    energy = float(march.column(outputs, "dissipated_energy")[-1])
    errors = reference.errors(march.elastic(motion), motion.displacement, energy)
    return Row(method, setting, errors, seconds, slow.seconds)


def _motion_rows(reference: Reference, slow: SlowCase, method: str, setting: str) -> Iterator[Row]:
    """Timed: the slow flow, and the fast motion at every sample of the window or of the run."""
    march, case = slow.march(20.0), reference.case
    window = case.times[case.in_window]
    ways = [("window", march.motion, window), ("motion", march.motion, case.times)]
    if slow.model.harmonics:
        ways.append(("sums", march.sums, case.times))
    for what, way, times in ways:

        def moved(way: Callable[..., Motion] = way, times: Floats = times) -> tuple[Floats, ...]:
            motion = way(march(), times)
            return march.elastic(motion), motion.displacement

        seconds, (x, x_c) = timed(moved, 3)
        part = case.times >= times[0]
        exact = reference.motion
        errors = (
            relative_rms(x, exact.displacement[part]),
            relative_rms(x_c[-window.size :], exact.contact_displacement[case.in_window]),
            float("nan"),
        )
        yield Row(f"{method}, {what}", setting, errors, seconds, slow.seconds)


def full_rows(reference: Reference, refinements: Sequence[int]) -> Iterator[Row]:
    """Our own full-order integration; its modal coordinates are prepared beforehand."""
    yield from _integrated(
        "full order", reference, reference.case, reference.case.observed, refinements
    )


def craig_bampton_rows(
    reference: Reference, modes: Sequence[int], refinements: Sequence[int]
) -> Iterator[Row]:
    """The same integrator on the usual reduction: a few modes and the static shapes of contacts.

    And of forces, as far as they have some of their own.
    """
    for count in modes:
        prepare, (case, basis) = timed(partial(on_component_modes, reference.case, count), 1)
        rows = basis[list(reference.case.observed)]
        yield from _integrated(
            f"Craig-Bampton, {count} modes", reference, case, rows, refinements, prepare
        )


def on_component_modes(case: Case, modes: int) -> tuple[Case, Floats]:
    """The case in the coordinates of Craig and Bampton, and its basis (n, coordinates)."""
    excitation = case.excitation
    found = full.component_modes(
        *(case.structure, case.law, excitation.patterns), max(case.frequency), modes=modes
    )
    basis = found.projection.basis
    force = tuple(found.projection.excitation(excitation).patterns)
    return replace(case, structure=found.structure, force=force), basis


def _integrated(
    method: str,
    reference: Reference,
    case: Case,
    outputs: Sequence[int] | Floats,
    refinements: Sequence[int],
    prepared: float = 0.0,
) -> Iterator[Row]:
    per_period = 2.0 * np.pi / max(case.frequency) / SAMPLING
    for refinement in refinements:
        make: Callable[[], Integrator] = partial(
            Integrator,
            case.structure,
            case.law,
            case.excitation,
            outputs,
            step=SAMPLING / refinement,
        )
        prepare, integrator = timed(make, 1)
        seconds, motion = timed(partial(integrator.run, case.times))
        errors = reference.errors(
            motion.displacement, motion.contact_displacement, float(motion.dissipated[-1])
        )
        setting = f"{per_period * refinement:.3g} steps per period"
        yield Row(method, setting, errors, seconds, prepared + prepare)


def first_order_rows(
    reference: Reference, name: str, integrate: Integrate, tolerances: Sequence[float]
) -> Iterator[Row]:
    """A general-purpose integrator."""
    case = reference.case
    contacts = as_dense(case.structure.directions)
    for tolerance in tolerances:
        problem = FirstOrder(case)

        def run(problem: FirstOrder = problem, tolerance: float = tolerance) -> Floats:
            problem.calls = 0
            return integrate(problem, case.times, tolerance)

        seconds, states = timed(run, 1)
        calls = problem.calls
        x = states[:, : case.structure.n_dofs]
        errors = reference.errors(x[:, list(case.observed)], x @ contacts)
        callback, _ = timed(partial(problem.rate, 0.0, states[-1]), 200)
        note = f"{calls} right-hand sides, compiled, {calls * callback / seconds:.0%} of the time"
        yield Row(name, f"rtol {tolerance:g}", errors, seconds, note=note)


def section(
    reference: Reference,
    title: str,
    rows: Sequence[Row],
    tolerance: float,
    flows: Sequence[tuple[float, float]],
) -> Section:
    """The rows as a section.

    Peers are compared with the slow flow at one table tolerance, for the first and the last of
    its communication steps [s] and tolerances, and with the whole fast motion, which is what
    they compute.
    """
    compared = [(SLOW, slow_setting(tolerance, *flow)) for flow in (flows[0], flows[-1])]
    names = [(row.method, row.setting) for row in rows]
    motions = [k for k, row in enumerate(rows) if row.method in _MOTIONS]
    case = reference.case
    return Section(
        key=case.name,
        title=title,
        task=f"{case.duration:g} s from rest, {case.times.size} samples of x",
        errors=ERRORS,
        reference_error=reference.error,
        rows=tuple(rows),
        ours=(*(names.index(name) for name in compared), *motions),
    )


def slow_setting(tolerance: float, step: float, flow: float) -> str:
    """Setting of a slow-flow row, in words."""
    return f"table {tolerance:g}, flow {flow:g}, step {step:g} s"
