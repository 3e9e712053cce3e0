"""Speed against error of displacements from rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks.cases import SAMPLING, Case
from benchmarks.measure import wall_time, worst_rms
from benchmarks.peers.first_order import FirstOrder, Integrate
from benchmarks.report.sections import OURS, Row, Section, position
from benchmarks.slow_case import Marcher, SlowCase
from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.rom.full import FullMotion
from slipmode.rom.full.integration import Integrator
from slipmode.rom.reduction.reduction import Formulation
from slipmode.rom.slow.motion import Motion
from slipmode.rom.structure.matrices import as_dense

ERRORS = ("x", "x_c in window", "energy")
SLOW = f"{OURS}, slow flow"
_REFERENCE_REFINEMENT = 64  # steps per sample
_LARGE = 20  # DOFs from which the reference takes a quarter of these steps
_FLOW = (20.0, 1e-6)  # communication step [s] and tolerance of the accuracy sections


@dataclass(frozen=True, eq=False)
class Reference:
    """Converged signals of a case, and the error that the worst displacement states."""

    case: Case
    motion: FullMotion
    error: float

    @classmethod
    def of(cls, case: Case) -> Reference:
        """Integrate at a small step, and at half of it."""
        step = SAMPLING / _REFERENCE_REFINEMENT
        found = full.converged(
            *(case.structure, case.law, case.excitation, case.times),
            step=4 * step if case.structure.n_dofs > _LARGE else step,
            outputs=case.observed,
        )
        return cls(case, found.motion, float(found.displacement_error.max()))

    def errors(
        self, x: Floats, x_c: Floats, energy: float = float("nan")
    ) -> tuple[float, float, float]:
        """Return the errors of displacements, contacts in the window, and dissipated energy."""
        window = self.case.in_window
        return (
            worst_rms(x, self.motion.displacement),
            worst_rms(x_c[window], self.motion.contact_displacement[window]),
            abs(energy / float(self.motion.dissipated[-1]) - 1.0),
        )


def slow_rows(
    reference: Reference,
    tolerances: Sequence[float],
    flows: Sequence[tuple[float, float]],
    formulation: Formulation = "consistent",
) -> Iterator[Row]:
    """Yield the slow flow at several table tolerances, communication steps [s] and tolerances.

    With the last table, the fast motion follows.
    """
    method = OURS if formulation == "consistent" else "paper formulation"
    for tolerance in tolerances:
        slow = SlowCase.tabulate(reference.case, tolerance, formulation)
        for step, flow in flows:
            setting = slow_setting(tolerance, step, flow)
            march = slow.march(step, flow)
            yield _slow_row(reference, slow, march, f"{method}, slow flow", setting)
    yield from _motion_rows(reference, slow, method, f"table {tolerance:g}")


def slow_setting(tolerance: float, step: float, flow: float) -> str:
    """Return the setting of a slow-flow row in words."""
    return f"table {tolerance:g}, flow {flow:g}, step {step:g} s"


def _slow_row(
    reference: Reference, slow: SlowCase, march: Marcher, method: str, setting: str
) -> Row:
    """Time of the amplitudes; errors of the motion that they describe."""
    seconds, outputs = wall_time(march, 9)
    motion = march.motion(outputs, reference.case.times)
    energy = float(march.column(outputs, "dissipated_energy")[-1])
    errors = reference.errors(march.elastic(motion), motion.displacement, energy)
    return Row(method, setting, errors, seconds, slow.seconds)


def _motion_rows(reference: Reference, slow: SlowCase, method: str, setting: str) -> Iterator[Row]:
    """Time of the slow flow and of the fast motion at every sample."""
    march, times = slow.march(20.0), reference.case.times
    ways = {"motion": march.motion}
    if slow.model.harmonics:
        ways["sums"] = march.sums
    for name, way in ways.items():

        def moved(way: Callable[..., Motion] = way) -> tuple[Floats, Floats]:
            motion = way(march(), times)
            return march.elastic(motion), motion.displacement

        seconds, signals = wall_time(moved, 3)
        errors = reference.errors(*signals)
        yield Row(f"{method}, {name}", setting, errors, seconds, slow.seconds)


def full_rows(reference: Reference, refinements: Sequence[int]) -> Iterator[Row]:
    """Yield our own full-order integration; its modal coordinates are prepared beforehand."""
    case = reference.case
    yield from _integrated("full order", reference, case, case.observed, refinements)


def craig_bampton_rows(
    reference: Reference, modes: Sequence[int], refinements: Sequence[int]
) -> Iterator[Row]:
    """Yield the same integrator on a few modes and the static shapes of contacts and forces."""
    for count in modes:
        prepare, (case, basis) = wall_time(partial(on_component_modes, reference.case, count), 1)
        rows = basis[list(reference.case.observed)]
        name = f"Craig-Bampton, {count} modes"
        yield from _integrated(name, reference, case, rows, refinements, prepare)


def on_component_modes(case: Case, modes: int) -> tuple[Case, Floats]:
    """Return the case in component coordinates, and their basis (n, coordinates)."""
    excitation = case.excitation
    found = full.component_modes(
        *(case.structure, case.law, excitation.patterns), max(case.frequency), modes=modes
    )
    force = tuple(found.projection.excitation(excitation).patterns)
    return replace(case, structure=found.structure, force=force), found.projection.basis


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
        make = partial(Integrator, case.structure, case.law, case.excitation, outputs)
        prepare, integrator = wall_time(partial(make, step=SAMPLING / refinement), 1)
        seconds, motion = wall_time(partial(integrator.run, case.times))
        errors = reference.errors(
            motion.displacement, motion.contact_displacement, float(motion.dissipated[-1])
        )
        setting = f"{per_period * refinement:.3g} steps per period"
        yield Row(method, setting, errors, seconds, prepared + prepare)


def first_order_rows(
    reference: Reference, name: str, integrate: Integrate, tolerances: Sequence[float]
) -> Iterator[Row]:
    """Yield a general-purpose integrator."""
    case, problem = reference.case, FirstOrder(reference.case)
    contacts = as_dense(case.structure.directions)
    for tolerance in tolerances:

        def run(tolerance: float = tolerance) -> Floats:
            problem.calls = 0
            return integrate(problem, case.times, tolerance)

        seconds, states = wall_time(run, 1)
        calls = problem.calls
        x = states[:, : case.structure.n_dofs]
        errors = reference.errors(x[:, list(case.observed)], x @ contacts)
        callback, _ = wall_time(partial(problem.rate, 0.0, states[-1]), 200)
        note = f"{calls} right-hand sides, compiled, {calls * callback / seconds:.0%} of the time"
        yield Row(name, f"rtol {tolerance:g}", errors, seconds, note=note)


def section(
    reference: Reference,
    rows: Sequence[Row],
    tolerance: float,
    flows: Sequence[tuple[float, float]],
) -> Section:
    """Return the section of these rows.

    Other methods are compared with the slow flow at one table tolerance, at the first and at the
    last of its communication steps [s] and tolerances, and with the whole fast motion, which is
    what they compute.
    """
    ours = [position(rows, SLOW, slow_setting(tolerance, *flow)) for flow in (flows[0], flows[-1])]
    motions = (f"{OURS}, motion", f"{OURS}, sums")
    case = reference.case
    return Section(
        title=f"signals, {case.name}",
        task=f"{case.duration:g} s from rest, {case.times.size} samples of x",
        run="run",
        errors=ERRORS,
        reference_error=reference.error,
        rows=tuple(rows),
        ours=(*ours, *(k for k, row in enumerate(rows) if row.method in motions)),
    )


def accuracy_section(case: Case, tolerance: float, refinements: Sequence[int]) -> Section:
    """Return the slow flow, with the error of steady amplitudes, and full order."""
    reference = Reference.of(case)
    slow = SlowCase.tabulate(case, tolerance)
    row = _slow_row(reference, slow, slow.march(*_FLOW), SLOW, f"table {tolerance:g}")
    ours = replace(row, errors=(*row.errors, _steady_error(slow)))
    others = (
        replace(each, errors=(*each.errors, float("nan")))
        for each in full_rows(reference, refinements)
    )
    return Section(
        title=case.name,
        task=f"{case.duration:g} s from rest",
        run="run",
        errors=(*ERRORS, "steady amplitude"),
        reference_error=reference.error,
        rows=(ours, *others),
        ours=(0,),
    )


def _steady_error(slow: SlowCase) -> float:
    """Worst relative error of the modal amplitudes."""
    case, model = slow.case, slow.model
    to_modal = as_dense(case.structure.mass @ model.reduced.mode_shapes).T
    exact = full.steady_amplitude(
        *(case.structure, case.law, case.excitation), outputs=to_modal, tolerance=3e-5
    )
    found = rom.steady(model, case.frequency, case.force)
    return float(np.abs(found / np.diag(exact.amplitude) - 1.0).max())
