"""Everything that figures and claims share, computed once, when it is first needed."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from benchmarks.paper.case import STRONG_FORCE, Case, Signals
from benchmarks.paper.slices import Sensitivity, Slices, peak
from benchmarks.slow_case import amplitudes, constant_inputs
from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import contact_harmonics
from slipmode.rom.reduction.combination import harmonic_orders

_STEADY = 1800.0  # ten times the slowest decay [s]
TRANSIENT = 600.0  # shown in Fig. 3 [s]
PERIODS = 12  # of the window in which steady motions are compared
FULL_ORDER_DETUNINGS = (-0.12, -0.06, -0.03, -0.015, 0.01, 0.04, 0.12)  # [rad/s]
TORUS_AMPLITUDES = (1.3, 1.5)  # |A|, |B| of Fig. 6
TORUS_ANGLES = np.linspace(0.0, 2 * np.pi, 97)

_SAMPLES_PER_PERIOD = 256


class Study:
    """The paper's example at full order, by its own model and by the consistent model."""

    def __init__(self) -> None:
        self.case = Case()
        self.strong = Case(force=STRONG_FORCE, largest=(16.0, 7.0), tolerance=3e-3)
        samples = np.arange(1 - PERIODS * _SAMPLES_PER_PERIOD, 1) / _SAMPLES_PER_PERIOD
        self.window = _STEADY + self.case.period * samples  # the last periods (n,) [s]

    @cached_property
    def alone_a(self) -> Signals:
        """Full order, mode A alone forced."""
        return self.case.by_full_order(self.window, forced="A")

    @cached_property
    def alone_b(self) -> Signals:
        """Full order, mode B alone forced."""
        return self.case.by_full_order(self.window, forced="B")

    @cached_property
    def both(self) -> Signals:
        """Full order, both modes forced."""
        return self.case.by_full_order(self.window)

    @cached_property
    def both_strong(self) -> Signals:
        """Full order under the larger forces."""
        return self.strong.by_full_order(self.window)

    @cached_property
    def paper(self) -> Signals:
        """The paper's model, both modes forced."""
        return self.case.by_model(self.case.paper, self.window)

    @cached_property
    def paper_strong(self) -> Signals:
        """The paper's model under the larger forces."""
        return self.strong.by_model(self.strong.paper, self.window)

    @cached_property
    def consistent(self) -> Signals:
        """The consistent model, both modes forced."""
        return self.case.by_model(self.case.consistent, self.window)

    @cached_property
    def consistent_strong(self) -> Signals:
        """The consistent model under the larger forces."""
        return self.strong.by_model(self.strong.consistent, self.window)

    @cached_property
    def from_rest(self) -> Signals:
        """Full order from t = 0 to TRANSIENT."""
        count = int(TRANSIENT / self.case.period * _SAMPLES_PER_PERIOD / 4)
        return self.case.by_full_order(np.linspace(0.0, TRANSIENT, count))

    @cached_property
    def envelope(self) -> tuple[Floats, Floats]:
        """Times (n,) and |A|, |B| (n, 2) of the consistent slow flow from rest to TRANSIENT."""
        component, steps = Component(self.case.consistent, self.case.forces()), int(TRANSIENT)
        inputs = constant_inputs(component, self.case.frequency.tolist(), steps)
        rows = component.run(np.ones(steps), inputs)
        time = rows[:, component.output_names.index("time")]
        return time, np.abs(amplitudes(component, rows))

    @cached_property
    def slices(self) -> Slices:
        """Resonance curves of the paper's model."""
        return Slices.of(self.case.paper)

    @cached_property
    def consistent_slices(self) -> Slices:
        """Resonance curves of the consistent model."""
        return Slices.of(self.case.consistent)

    @cached_property
    def both_by_full_order(self) -> tuple[Floats, Floats]:
        """|A|, |B| (n, 2) over the detunings of A, then of B, the other mode at its peak."""
        peak_a, peak_b = peak(self.slices.alone_a)[0], self.slices.detuning_b
        over_a = [(detuning, peak_b) for detuning in FULL_ORDER_DETUNINGS]
        over_b = [(peak_a, detuning) for detuning in FULL_ORDER_DETUNINGS]
        found_a, found_b = (
            np.abs([replace(self.case, detuning=pair).steady_by_full_order() for pair in pairs])
            for pairs in (over_a, over_b)
        )
        return found_a, found_b

    @cached_property
    def surface(self) -> rom.ResonanceSurface:
        """Resonance surface of the paper's model, finer around the peaks."""
        omega = self.case.paper.reduced.frequency
        detunings = np.unique(np.r_[np.linspace(-0.2, 0.2, 41), np.linspace(-0.1, 0.06, 65)])
        return rom.resonance(
            self.case.paper, self.case.forces(), omega[0] + detunings, omega[1] + detunings
        )

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Resonance curves over alpha and beta."""
        return Sensitivity()

    @cached_property
    def torus(self) -> Floats:
        """x_c1 (97, 97) [m] at TORUS_AMPLITUDES over TORUS_ANGLES of t_A and t_B."""
        orders, grid = harmonic_orders(21, 2), Discretisation(steps=512, lines=64)
        reduced, law = self.case.paper.reduced, self.case.law
        P = contact_harmonics(reduced, law, [TORUS_AMPLITUDES], grid, orders).P[0, :, 0]
        waves_A, waves_B = (np.exp(1j * np.outer(n, TORUS_ANGLES)) for n in np.array(orders).T)
        return np.asarray(2 * np.real(np.einsum("q,qa,qb->ab", P, waves_A, waves_B)))
