"""Everything that the figures and the claims share, computed once and when first needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import contact_harmonics
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.runner.paper.case import STRONG_FORCE, Case, Signals
from slipmode.runner.paper.slices import Sensitivity, Slices, peak

SETTLED = 1800.0  # [s], ten times the slowest decay
TRANSIENT = 600.0  # [s], shown in Fig. 3
PERIODS = 12  # of the window in which steady motions are compared
FULL_ORDER_DETUNINGS = (-0.12, -0.06, -0.03, -0.015, 0.01, 0.04, 0.12)  # [rad/s]
TORUS_AMPLITUDES = (1.3, 1.5)  # |A|, |B| of Fig. 6

_SAMPLES_PER_PERIOD = 256
_TORUS_ORDER = 21
_TORUS_GRID = Discretisation(steps=512, lines=64)


class Study:
    """The paper's example by the full order, by its own model and by the consistent one."""

    def __init__(self) -> None:
        self.case = Case()
        self.strong = Case(force=STRONG_FORCE, largest=(16.0, 7.0), tolerance=3e-3)

    @cached_property
    def window(self) -> Floats:
        """Times (n,) of the last periods before SETTLED."""
        count = PERIODS * _SAMPLES_PER_PERIOD
        return SETTLED + self.case.period * np.arange(1 - count, 1) / _SAMPLES_PER_PERIOD

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
        component = Component(self.case.consistent, force_patterns=({0: 1.0}, {1: 1.0}))
        given = dict.fromkeys(component.input_names, 0.0)
        for mode, force, frequency in zip("AB", self.case.force, self.case.frequency, strict=True):
            given |= {f"force_{mode}": force, f"frequency_{mode}": frequency}
        steps = int(TRANSIENT)
        rows = component.run(np.ones(steps), np.tile(list(given.values()), (steps, 1)))
        column = {name: k for k, name in enumerate(component.output_names)}
        parts = [np.hypot(rows[:, column[f"{m}_re"]], rows[:, column[f"{m}_im"]]) for m in "AB"]
        return rows[:, column["time"]], np.column_stack(parts)

    @cached_property
    def slices(self) -> Slices:
        """Resonance curves of the paper's model."""
        return Slices.of(self.case.paper)

    @cached_property
    def consistent_slices(self) -> Slices:
        """Resonance curves of the consistent model."""
        return Slices.of(self.case.consistent)

    @cached_property
    def both_a_by_full_order(self) -> Floats:
        """|A|, |B| (n, 2) over the detunings of A, mode B at its peak."""
        return self._by_full_order(lambda detuning: (detuning, self.slices.detuning_b))

    @cached_property
    def both_b_by_full_order(self) -> Floats:
        """|A|, |B| (n, 2) over the detunings of B, mode A at its peak."""
        at_peak = peak(self.slices.alone_a)[0]
        return self._by_full_order(lambda detuning: (at_peak, detuning))

    def _by_full_order(self, pair: Callable[[float], tuple[float, float]]) -> Floats:
        cases = [replace(self.case, detuning=pair(d)) for d in FULL_ORDER_DETUNINGS]
        return np.array([np.abs(case.steady_by_full_order()) for case in cases])

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
        """The three numbers over alpha and beta."""
        return Sensitivity.over_grid()

    @cached_property
    def torus(self) -> Floats:
        """x_c1 (97, 97) [m] at TORUS_AMPLITUDES over t_A, t_B from 0 to 2 pi."""
        orders = harmonic_orders(_TORUS_ORDER, 2)
        solved = contact_harmonics(
            *(self.case.paper.reduced, self.case.law, [TORUS_AMPLITUDES], _TORUS_GRID, orders)
        )
        n, m = np.array(orders).T
        t = torus_angles()
        waves_A, waves_B = np.exp(1j * np.outer(n, t)), np.exp(1j * np.outer(m, t))
        return np.asarray(
            2 * np.real(np.einsum("q,qa,qb->ab", solved.P[0, :, 0], waves_A, waves_B))
        )


def torus_angles() -> Floats:
    """Angles of the grid on the torus, (97,), from 0 to 2 pi."""
    return np.linspace(0.0, 2 * np.pi, 97)
