"""After how many full-order runs a friction table pays: make bench-table.

Processor seconds of a two-mode table and of a steady state without a table, over those of full
order through 160 cycles of mode A at the largest step with an error of 0.1 %: on the two-mass
model and on a meshed blade with more and more Jenkins contacts, on component modes. Forcing stays
at the carriers, and tables are made as scenes make them then. The error of the amplitudes of a run
is measured with a table of a smaller tolerance.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom import full
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.full.convergence import relative_rms
from slipmode.rom.full.integration import Integrator
from slipmode.rom.laws.friction import Friction
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.blade import blade
from slipmode.runner.report.measure import one_thread

T = TypeVar("T")

_CONTACTS = (4, 12, 30, 100)
_DOFS, _HARMONICS, _FIRST = 3000, 7, 1e8  # of the meshed blade; of B on component modes; k_t [N/m]
_RATIO, _SLIPPING, _DETUNED = 4e-3, 0.15, 0.99  # damping; limit, of the stuck force; forcing
_CYCLES, _SAMPLES = 160, 16
_ERROR = 1e-3
_STEPS = (8, 12, 16, 20, 24, 32, 40, 48, 64, 96, 128)  # per period of B
_EXACT = 512
_BEYOND = 1.15  # range of a table, over what full order reaches
_CLOSER = 5.0  # times, is the table that tells the error of runs


class Case(NamedTuple):
    """A structure near two of its modes, which both slip."""

    name: str
    structure: rom.Structure
    reduced: rom.Reduced
    law: Friction
    force: tuple[Floats, Floats]
    frequency: tuple[float, float]

    @property
    def times(self) -> Floats:
        """Sixteen samples a cycle of A [s]."""
        period = 2.0 * np.pi / self.frequency[0]
        return np.asarray(period / _SAMPLES * np.arange(1, _CYCLES * _SAMPLES + 1))

    def integrated(self, steps: int) -> Callable[[], Floats]:
        """Full order from rest, prepared: displacements of both modes."""
        excitation = full.Excitation.harmonic(self.structure, self.force, self.frequency)
        mass = as_dense(self.structure.mass)
        rows = self.reduced.mode_shapes.T @ mass
        integrator = Integrator(self.structure, self.law, excitation, rows, steps_per_period=steps)
        return lambda: integrator.run(self.times).displacement


class Costs(NamedTuple):
    """Processor seconds of full order, a table and a steady state, and their settings.

    `error` of the amplitudes of a run on the table: RMS, relative, of the worse mode.
    """

    full_order: float
    table: float
    steady: float
    error: float
    notes: str


def two_mass() -> Case:
    """The paper's structure, as the shipped scene forces it."""
    structure = rom.two_mass(beta=0.01)
    force = np.diag([0.15, 0.25, 0.0, 0.0])
    law, frequency = rom.Tanh(limit=2.0, alpha=0.02), (0.97, 1.64)
    reduced = rom.reduce(structure)
    arguments = structure, reduced, law
    return Case("two-mass, tanh", *arguments, (force[0], force[1]), frequency)


def jenkins_blade(contacts: int) -> Case:
    """The blade on component modes: most contacts slip where both modes are at their peaks."""
    matrices, stuck = blade(_DOFS, contacts), rom.Jenkins(1.0, _FIRST)
    bare = rom.Structure(**matrices, damping=0.0)
    omega = rom.reduce(bare, (0, 1), law=stuck).frequency
    structure = rom.Structure(
        **matrices, damping=rom.Rayleigh.from_ratios([_RATIO] * 2, omega.tolist())
    )
    tip = np.zeros(structure.n_dofs)
    tip[-1] = 1.0
    small = full.component_modes(structure, stuck, [tip], _HARMONICS * float(omega[1]))
    pattern = tip @ small.projection.basis
    amplitude = np.abs(pattern[:2]) / (2.0 * _RATIO * omega**2)
    sizes = amplitude[0] / amplitude * np.array([1.0, 0.5])  # B half as strong
    moved = np.abs(as_dense(small.structure.directions)[:2]) * (amplitude * sizes)[:, np.newaxis]
    limit = _SLIPPING * _FIRST * float(np.median(moved.sum(axis=0)))
    law = rom.Jenkins(limit, _FIRST)
    force = (pattern * sizes[0], pattern * sizes[1])
    reduced = rom.reduce(small.structure, (0, 1), law=law, force_patterns=force)
    return Case(
        f"blade, {contacts} Jenkins",
        *(small.structure, reduced, law),
        force=force,
        frequency=(_DETUNED * float(omega[0]), _DETUNED * float(omega[1])),
    )


def _seconds(run: Callable[[], T]) -> tuple[float, T]:
    """Of the processor, all threads of it."""
    started = time.process_time()
    result = run()
    return time.process_time() - started, result


def costs(case: Case, tolerance: float) -> Costs:
    """Measured one after the other."""
    exact = case.integrated(_EXACT)()
    for steps in _STEPS:
        run = case.integrated(steps)
        full_order, motion = min((_seconds(run) for _ in range(2)), key=lambda found: found[0])
        error = float(relative_rms(motion, exact).max())
        if error <= _ERROR:
            break
    reach = _BEYOND * 0.5 * np.abs(exact).max(axis=0)
    reduced = case.reduced.at_carrier(case.frequency)
    made = partial(rom.tabulate, reduced, case.law, reach, detuning=False)
    table, model = _seconds(partial(made, tolerance=tolerance))
    amplitude = _run(case, model)
    closer = made(tolerance=tolerance / _CLOSER)
    runs = (np.vstack((each.real, each.imag)) for each in (amplitude, _run(case, closer)))
    of_run = float(relative_rms(*runs).max())
    arguments = case.reduced, case.law, case.frequency, case.force, tolerance
    steady, found = min(
        (_seconds(lambda: rom.steady_state(*arguments)) for _ in range(2)),
        key=lambda each: each[0],
    )
    accuracy = model.accuracy
    notes = (
        f"full order {steps} steps; {accuracy.steps} x {accuracy.lines}, {accuracy.solved} "
        f"points; {found.method}"
    )
    return Costs(full_order, table, steady, of_run, notes)


def _run(case: Case, model: rom.Model) -> Complexes:
    """a_A, a_B of the run from rest, a cycle of A at a time, (steps + 1, 2)."""
    component = Component(model, case.force)
    period = 2.0 * np.pi / case.frequency[0]
    inputs = {"force_A": 1.0, "force_B": 1.0}
    inputs |= {f"frequency_{m}": f for m, f in zip("AB", case.frequency, strict=True)}
    row = [inputs.get(name, 0.0) for name in component.input_names]
    if "limit_scale" in component.input_names:
        row[component.input_names.index("limit_scale")] = 1.0
    rows = component.run(np.full(_CYCLES, period), np.tile(row, (_CYCLES, 1)))
    re, im = (
        rows[:, [component.output_names.index(f"{mode}_{part}") for mode in "AB"]]
        for part in ("re", "im")
    )
    return np.vstack((np.zeros(2), re + 1j * im))


def main(tolerance: float, numbers: Sequence[int]) -> None:
    """Print the table; `numbers` are those of contacts, 2 for the two-mass model."""
    os.environ["SLIPMODE_CACHE_MIB"] = "0"
    print(f"tables and steady states to {tolerance:g}")
    heads = f"{'table':>20}{'steady state':>20}{'error of run':>14}"
    print(f"{'':22}{'full order':>12}{heads}")
    with one_thread():
        for number in numbers:
            case = two_mass() if number == 2 else jenkins_blade(number)
            found = costs(case, tolerance)
            cells = "".join(
                f"{seconds:9.3g} s {seconds / found.full_order:6.1f} x"
                for seconds in (found.table, found.steady)
            )
            cells += f"{100.0 * found.error:12.2f} %"
            print(f"{case.name:22}{found.full_order:10.3g} s{cells}  {found.notes}", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]), [int(number) for number in sys.argv[2:]] or [2, *_CONTACTS])
