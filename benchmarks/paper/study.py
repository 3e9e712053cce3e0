"""Everything that figures and claims are made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.paper.case import STRONG_FORCE, Case
from benchmarks.paper.slices import Sensitivity, Slices, peak
from benchmarks.slow_case import amplitudes, constant_inputs
from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.reduction.combination import harmonic_orders

_STEADY = 1800.0  # ten times the slowest decay [s]
TRANSIENT = 600.0  # shown in Fig. 3 [s]
PERIODS = 12  # of the window in which steady motions are compared
_SAMPLES_PER_PERIOD = 256
FULL_ORDER_DETUNINGS = (-0.12, -0.06, -0.03, -0.015, 0.01, 0.04, 0.12)  # [rad/s]
TORUS_AMPLITUDES = (1.3, 1.5)  # |A|, |B| of Fig. 6
TORUS_ANGLES = np.linspace(0.0, 2 * np.pi, 97)


class Study:
    """The paper's example at full order, by the paper's model and by the consistent model.

    Motions under the forces of Table 1, and `_strong` under the larger forces of Fig. 8, are of
    the last periods before 1800 s. All is computed at once: half a minute.
    """

    def __init__(self) -> None:
        self.case = case = Case()
        self.strong = strong = Case(force=STRONG_FORCE, largest=(16.0, 7.0), tolerance=3e-3)
        samples = np.arange(1 - PERIODS * _SAMPLES_PER_PERIOD, 1) / _SAMPLES_PER_PERIOD
        window = _STEADY + case.period * samples
        self.alone_a = case.by_full_order(window, forced="A")
        self.alone_b = case.by_full_order(window, forced="B")
        self.both = case.by_full_order(window)
        self.both_strong = strong.by_full_order(window)
        self.paper = case.by_model(case.paper, window)
        self.paper_strong = strong.by_model(strong.paper, window)
        self.consistent = case.by_model(case.consistent, window)
        self.consistent_strong = strong.by_model(strong.consistent, window)
        count = int(TRANSIENT / case.period * _SAMPLES_PER_PERIOD / 4)
        self.from_rest = case.by_full_order(np.linspace(0.0, TRANSIENT, count))
        self.envelope = _envelope(case)
        # resonance curves and surface, finer around the peaks; over alpha and beta
        self.slices = Slices.of(case.paper)
        self.consistent_slices = Slices.of(case.consistent)
        detunings = np.unique(np.r_[np.linspace(-0.2, 0.2, 41), np.linspace(-0.1, 0.06, 65)])
        axes = [omega + detunings for omega in case.paper.reduced.frequency]
        self.surface = rom.resonance(case.paper, case.forces(), *axes)
        self.sensitivity = Sensitivity()
        # |A|, |B| (n, 2) over the detunings of A, then of B, the other mode at its peak
        peak_a, peak_b = peak(self.slices.alone_a)[0], self.slices.detuning_b
        self.both_by_full_order = (
            _by_full_order(case, [(detuning, peak_b) for detuning in FULL_ORDER_DETUNINGS]),
            _by_full_order(case, [(peak_a, detuning) for detuning in FULL_ORDER_DETUNINGS]),
        )
        self.torus = _torus(case)


def _envelope(case: Case) -> tuple[Floats, Floats]:
    """Times (n,) and |A|, |B| (n, 2) of the consistent slow flow from rest to TRANSIENT."""
    component, steps = Component(case.consistent, case.forces()), int(TRANSIENT)
    inputs = constant_inputs(component, case.frequency.tolist(), steps)
    rows = component.run(np.ones(steps), inputs)
    return rows[:, component.output_names.index("time")], np.abs(amplitudes(component, rows))


def _by_full_order(case: Case, detunings: Sequence[tuple[float, float]]) -> Floats:
    cases = [replace(case, detuning=pair) for pair in detunings]
    return np.array([np.abs(each.steady_by_full_order()) for each in cases])


def _torus(case: Case) -> Floats:
    """x_c1 (97, 97) [m] at TORUS_AMPLITUDES over TORUS_ANGLES of t_A and t_B."""
    orders, grid = harmonic_orders(21, 2), Discretisation(steps=512, lines=64)
    reduced, law = case.paper.reduced, case.law
    P = ContactProblem(reduced, law, tuple(orders)).on(grid).solve([TORUS_AMPLITUDES]).P[0, :, 0]
    waves_A, waves_B = (np.exp(1j * np.outer(n, TORUS_ANGLES)) for n in np.array(orders).T)
    return np.asarray(2 * np.real(np.einsum("q,qa,qb->ab", P, waves_A, waves_B)))
