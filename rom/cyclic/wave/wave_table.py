"""Friction tables of travelling waves: models of one wave, or of two at two frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, cast

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import MOST_DETUNING
from slipmode.rom.contact.error_norm import ErrorNorm, smallest_scale
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.resolution import ResolutionSearch
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.cyclic.wave.wave_problem import Carrier, wave_contact_problem
from slipmode.rom.cyclic.wave.wave_resonances import naming_resonance, resonance_findings
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import warn
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.modes_alone import modes_alone
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.corrections import probe_points, with_rate_correction, with_slopes
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.refine import refine
from slipmode.rom.table.refinement.sampling import Sampling


def reduced_waves(carriers: Sequence[Carrier]) -> Reduced:
    """Return one or two waves as modes without contacts, with the sizes of their shapes."""
    return modes_alone(
        np.array([each.natural_frequency for each in carriers]),
        np.array([each.damping for each in carriers]),
        np.abs([each.mode_shape for each in carriers]).T,
        NoContacts().elements(0),
        carrier=np.array([each.frequency for each in carriers]),
        aerodynamics=np.array([each.aerodynamics for each in carriers]),
    )


@frozen
class _Detuned:
    """Friction terms of waves whose carriers move by MOST_DETUNING.

    Attributes
    ----------
    carriers : sequence of Carrier
    torus : TorusProblem
        At the carriers.
    """

    carriers: Sequence[Carrier]
    torus: TorusProblem

    def friction(self, points: Floats, sides: Sequence[float]) -> Complexes:
        """Return S (points, modes) with carriers times 1 + MOST_DETUNING * sides (modes,)."""
        moved = [
            replace(each, frequency=each.frequency * (1.0 + MOST_DETUNING * side))
            for each, side in zip(self.carriers, sides, strict=True)
        ]
        torus, law = self.torus, cast(Elastic, self.torus.problem.law)
        problem = wave_contact_problem(moved, law)
        terms = problem.on(torus.grid, torus.march.tolerance, torus.smallest_amplitude)
        indirect = np.array([each.mode.indirect for each in moved])
        return np.asarray(terms.solve(points).S - indirect * points)

    def slope(self, points: Floats) -> Complexes:
        """Return dS_j / dOmega_k by central differences, (points, modes, modes)."""
        found = []
        for k, each in enumerate(np.eye(len(self.carriers))):
            change = self.friction(points, each.tolist()) - self.friction(points, (-each).tolist())
            found.append(change / (2.0 * MOST_DETUNING * self.carriers[k].frequency))
        return np.stack(found, axis=-1)

    def error(self, table: Table, norm: ErrorNorm) -> float:
        """Return the error that is left MOST_DETUNING from the carriers, see `ErrorNorm`."""
        points, modes = probe_points(table), len(self.carriers)
        at_carriers = self.friction(points, [0.0] * modes)
        scale = norm.known(table.nodes()[..., :modes]).scale(points, at_carriers)
        off = MOST_DETUNING * np.array([each.frequency for each in self.carriers])
        largest = 0.0
        for sides in product((1.0, -1.0), repeat=modes):
            slope = table.detuning_at(points) @ (off * np.array(sides))
            left = self.friction(points, sides) - at_carriers - slope
            largest = max(largest, float((np.abs(left) / scale).max()))
        return largest


def wave_model(carriers: Sequence[Carrier], law: Elastic, ends: Floats, tolerance: float) -> Model:
    """Return the model of one or two waves up to amplitudes `ends` (modes,) [kg^1/2 m].

    Its DOFs are the free DOFs of a sector, with the sizes of the modes as mode shapes.
    """
    problem = wave_contact_problem(carriers, law)
    warn(resonance_findings(carriers, problem))
    with naming_resonance(carriers, problem):
        return _tabulated(carriers, problem, ends, tolerance)


def _tabulated(
    carriers: Sequence[Carrier], problem: ContactProblem, ends: Floats, tolerance: float
) -> Model:
    budget, forever, modes = ErrorBudget(tolerance), TimeBudget(np.inf), len(carriers)
    resolution = ResolutionSearch(problem, ends, map, forever).choose(budget)
    scale = smallest_scale(problem.reduced, ends)
    torus = problem.on(resolution.grid, resolution.march, scale)
    norm = ErrorNorm.of(problem.reduced, ends)
    indirect = np.array([each.mode.indirect for each in carriers])
    residuals: list[Any] = [np.zeros(1)]

    def sample(amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        terms = torus.solve(amplitudes)
        terms.check_periodic()
        residuals.append(terms.residual)
        return np.hstack((terms.S - indirect * amplitudes, np.zeros((len(terms.S), 1))))

    sampling = Sampling(
        sample,
        orders=(*CARRIERS[:modes], CARRIERS[0]),
        drives=tuple(range(modes)),
        norm=norm,
        carrier=problem.reduced.carrier,
        loss=norm.loss,
        amplitude_range=ends,
        onset_lines=onset_lines(problem.reduced, problem.law),
        noise=budget.march,
    )
    table, _, error = refine(sampling, budget.interpolation, forever)
    # Phases between the contacts of a sector are left out: they matter in second order.
    table = with_rate_correction(table, torus, tolerance, lambda solve, points: [solve(points)])
    detuned = _Detuned(carriers, torus)
    table = with_slopes(table, detuned.slope, lambda solve, points: [solve(points)])
    reduced = reduced_waves(carriers)
    nodes = tuple(axis.size for axis in table.axes)
    nothing = np.zeros((*nodes, modes, 0))
    unknown = Harmonics(table.axes, CARRIERS[:modes], nothing.astype(complex), nothing[..., 0, :])
    solved = np.concatenate(residuals)
    accuracy = Accuracy(
        tolerance,
        interpolation=error,
        resolution=resolution.error,
        periodicity=float(solved.max()),
        neglected_response=0.0,
        neglected_modes=0.0,
        detuning=detuned.error(table, norm),
        steps=resolution.grid.steps,
        lines=resolution.grid.lines,
        solved=solved.size - 1,
    )
    return Model(reduced, NoContacts(), table, unknown, (), accuracy)
