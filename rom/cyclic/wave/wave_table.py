"""Friction tables of travelling waves: models of one wave, or of two at two frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import DIFFERENCE, MOST_DETUNING
from slipmode.rom.contact.error_norm import ErrorNorm, smallest_scale
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.resolution import ResolutionSearch
from slipmode.rom.contact.slip_onset import onset_lines
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.cyclic.wave.wave_dofs import wave_dof_response
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
    """Friction terms of one wave whose carrier moves by MOST_DETUNING.

    Attributes
    ----------
    carrier : Carrier
    torus : TorusProblem
        At the carrier.
    """

    carrier: Carrier
    torus: TorusProblem

    def friction(self, points: Floats, distance: float) -> Complexes:
        """Return S (points, 1) at a relative distance from the carrier."""
        frequency = self.carrier.frequency * (1.0 + distance)
        moved = replace(self.carrier, frequency=frequency)
        torus, law = self.torus, cast(Elastic, self.torus.problem.law)
        problem = wave_contact_problem([moved], law)
        terms = problem.on(torus.grid, torus.march.tolerance, torus.smallest_amplitude)
        return np.asarray(terms.solve(points).S - moved.mode.indirect * points)

    def slope(self, points: Floats) -> Complexes:
        """Return dS / dOmega by central differences, (points, 1, 1)."""
        change = self.friction(points, DIFFERENCE) - self.friction(points, -DIFFERENCE)
        return np.asarray(change[..., np.newaxis] / (2.0 * DIFFERENCE * self.carrier.frequency))

    def error(self, table: Table, norm: ErrorNorm) -> float:
        """Return the error that is left MOST_DETUNING from the carrier, see `ErrorNorm`."""
        points = probe_points(table)
        at_carrier = self.friction(points, 0.0)
        scale = norm.known(table.nodes()[..., :1]).scale(points, at_carrier)
        change = MOST_DETUNING * self.carrier.frequency * table.detuning_at(points)[..., 0]
        left = [
            self.friction(points, s * MOST_DETUNING) - at_carrier - s * change for s in (1.0, -1.0)
        ]
        return float((np.abs(left) / scale).max())


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
        S = terms.S - indirect * amplitudes
        at_carriers = terms.P[:, :modes].reshape(len(S), -1)
        return np.hstack((S, np.zeros((len(S), 1)), at_carriers))

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
        kept=True,
    )
    table, deficits, error = refine(sampling, budget.interpolation, forever)
    # Phases between the contacts of a sector are left out: they matter in second order.
    table = with_rate_correction(table, torus, tolerance, lambda solve, points: [solve(points)])
    detuning = None
    if modes == 1:
        detuned = _Detuned(carriers[0], torus)
        table = with_slopes(table, detuned.slope, lambda solve, points: [solve(points)])
        detuning = detuned.error(table, norm)
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
        detuning=detuning,
        steps=resolution.grid.steps,
        lines=resolution.grid.lines,
        solved=solved.size - 1,
    )
    assert deficits is not None  # they are kept
    response = wave_dof_response(carriers, table.axes, deficits.reshape(*nodes, modes, -1))
    return Model(reduced, NoContacts(), table, unknown, (), accuracy, response)
