"""After how many full-order runs a friction table pays: make bench-table.

Processor seconds of a two-mode table and of a steady state without a table, over full order
through 160 cycles of mode A at the largest step with an error of 0.1 %: on the two-mass model and
on a meshed blade with Jenkins contacts. Forcing stays at the carriers. The error of a run on the
table is measured with a table of a smaller tolerance.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from functools import partial

import numpy as np

from benchmarks.blade import CYCLES, DenseCase, jenkins_blade
from benchmarks.measure import one_thread, processor_time, worst_rms
from benchmarks.slow_case import amplitudes, constant_inputs
from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.arrays import Floats

_CONTACTS = (2, 4, 12, 30, 100)  # 2: the two-mass model
_ERROR = 1e-3
_STEPS = (8, 12, 16, 20, 24, 32, 40, 48, 64, 96, 128)  # per period of B
_EXACT_STEPS = 512
_MARGIN = 1.15  # range of a table over the amplitudes of full order
_CLOSER = 5.0  # tolerance of the table over the tolerance of its reference


def two_mass() -> DenseCase:
    """Return the paper's structure, forced as in the shipped scene."""
    structure = rom.two_mass(beta=0.01)
    force = np.diag([0.15, 0.25, 0.0, 0.0])
    law, reduced = rom.Tanh(limit=2.0, alpha=0.02), rom.reduce(structure)
    forces, frequency = (force[0], force[1]), (0.97, 1.64)
    return DenseCase("two-mass, tanh", structure, reduced, law, forces, frequency)


def compare(case: DenseCase, tolerance: float) -> str:
    """Measure full order, a table and a steady state one after the other; return the line."""
    exact = case.integrated(_EXACT_STEPS)().displacement
    for steps in _STEPS:
        full_order, motion = processor_time(case.integrated(steps), 2)
        if worst_rms(motion.displacement, exact) <= _ERROR:
            break
    reach = (_MARGIN * 0.5 * np.abs(exact).max(axis=0)).tolist()
    reduced = case.reduced.at_carrier(case.frequency)
    tabulate = partial(rom.tabulate, reduced, case.law, reach, detuning=False)
    table, model = processor_time(partial(tabulate, tolerance=tolerance))
    closer = tabulate(tolerance=tolerance / _CLOSER)
    error = worst_rms(_run(case, model), _run(case, closer))  # of the amplitudes, the worse mode
    arguments = (case.reduced, case.law, case.frequency, case.force, tolerance)
    steady, found = processor_time(lambda: rom.steady_state(*arguments), 2)
    accuracy = model.accuracy
    return (
        f"{case.name:22}{full_order:10.3g} s{table:9.3g} s {table / full_order:6.1f} x"
        f"{steady:9.3g} s {steady / full_order:6.1f} x{100.0 * error:12.2f} %  full order {steps} "
        f"steps; {accuracy.steps} x {accuracy.lines}, {accuracy.solved} points; {found.method}"
    )


def _run(case: DenseCase, model: rom.Model) -> Floats:
    """Real and imaginary parts of both amplitudes from rest, stacked, a cycle of A at a time."""
    component = Component(model, case.force)
    period = 2.0 * np.pi / case.frequency[0]
    inputs = constant_inputs(component, case.frequency, CYCLES)
    found = amplitudes(component, component.run(np.full(CYCLES, period), inputs))
    return np.vstack((found.real, found.imag))


def main(tolerance: float, numbers: Sequence[int]) -> None:
    """Print the table for numbers of contacts."""
    os.environ["SLIPMODE_CACHE_MIB"] = "0"
    print(f"tables and steady states to {tolerance:g}")
    heads = f"{'table':>20}{'steady state':>20}{'error of run':>14}"
    print(f"{'':22}{'full order':>12}{heads}")
    with one_thread():
        for number in numbers:
            case = two_mass() if number == 2 else jenkins_blade(number)
            print(compare(case, tolerance), flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]), [int(number) for number in sys.argv[2:]] or _CONTACTS)
