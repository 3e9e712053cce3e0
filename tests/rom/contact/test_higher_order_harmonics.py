"""Modes near a high harmonic of the contacts: they respond to it, and the table knows."""

import numpy as np
import pytest
from elastic.chain import chain
from elastic.family import member

from benchmarks.blade import jenkins_blade
from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation
from slipmode.rom.contact.error_norm import ErrorNorm
from slipmode.rom.contact.higher_order_harmonics import change_by_harmonics, higher_order_harmonics
from slipmode.rom.contact.resolution import ResolutionSearch, trial_grid
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.short_repr import percentage

PLATE = member(50)  # 27 Jenkins contacts; a mode at 7.31 rad/s, forced at 1.046
AMPLITUDE = 0.2


def plate():
    return rom.reduce(
        *(PLATE.structure, PLATE.modes),
        law=PLATE.law,
        carrier=PLATE.frequency,
        smallest_response=3e-3,
    )


def test_a_mode_at_the_seventh_harmonic_responds():
    reduced = plate()
    model = rom.tabulate(reduced, PLATE.law, (AMPLITUDE,), 1e-2, warned=False)
    points = AMPLITUDE * np.array([[0.4], [0.7], [0.9]])
    grid = Discretisation(512, 1)
    exact = ContactProblem.of(reduced, PLATE.law, highest=25).on(grid, 1e-6).solve(points).S
    without = (
        ContactProblem.of(reduced, PLATE.law, highest=RESPONSE_ORDER)
        .on(grid, 1e-6)
        .solve(points)
        .S
    )
    largest = np.abs(model.table.nodes()[..., 0]).max()
    assert np.abs(without - exact).max() > 0.03 * largest  # measured 0.034
    assert np.abs(model.table(points) - exact).max() < 1e-2 * largest
    # the motion does not converge with the harmonics beyond the 15th
    assert 0.0 < model.accuracy.neglected_response < 1e-2


def test_the_strongest_response_comes_first():
    problem = ContactProblem.of(plate(), PLATE.law)
    found = higher_order_harmonics(problem, Discretisation(256, 1), np.array([AMPLITUDE]), 1e-3)
    assert list(found)[:2] == [(7, 0), (9, 0)]
    assert list(found.values()) == sorted(found.values(), reverse=True)
    assert min(found.values()) > 1e-3


@pytest.mark.slow
def test_the_first_look_finds_those_that_change_the_forces():
    """Without those of |m| > 7, which 16 lines would hide, S is 0.09 % off; with them 0.05 %."""
    case, tolerance = jenkins_blade(4), 1e-3
    reduced, largest = case.reduced.at_carrier(case.frequency), np.array([7.775e-6, 1.029e-5])
    problem, budget = ContactProblem.of(reduced, case.law), ErrorBudget(tolerance)
    trial = trial_grid(problem, tolerance)
    first = list(higher_order_harmonics(problem, trial, largest, budget.response))
    complete = ContactProblem.of(reduced, case.law, higher_orders=first)
    search = ResolutionSearch(complete, largest, map, TimeBudget(np.inf), is_optional=True)
    found = search.choose(budget)
    points = np.random.default_rng(1).uniform(0.2, 1.0, (40, 2)) * largest

    def forces(grid, further, march):
        responding = ContactProblem.of(reduced, case.law, higher_orders=further)
        return responding.on(grid, march, 0.1 * largest).solve(points).S

    fine = Discretisation(256, 64)
    every = list(higher_order_harmonics(problem, fine, largest, 0.1 * budget.response))
    exact = forces(fine, every, 1e-6)

    def off(further):
        error = np.abs(forces(found.grid, further, found.march) - exact)
        return float((error / np.abs(exact).max(axis=0)).max())

    assert off(first) < 0.6 * tolerance
    assert off([(n, m) for n, m in first if abs(m) <= 7]) > 0.75 * tolerance


def test_modes_do_not_respond_to_those_that_lines_take_for_others():
    case = jenkins_blade(12)
    reduced, largest = case.reduced.at_carrier(case.frequency), np.array([4.895e-6, 7.752e-6])

    def solved(orders, lines):
        problem = ContactProblem(reduced, case.law, tuple(orders))
        return problem.on(Discretisation(64, lines), 1e-6).solve([0.8 * largest])

    orders = [*CARRIERS, (1, 6)]
    alone, beside = solved(orders, 16), solved([*orders, (1, -12)], 16)  # 18 lines close
    assert np.all(beside.P[:, 3] == 0.0)
    np.testing.assert_allclose(
        beside.P[:, :3], alone.P, rtol=0.0, atol=1e-5 * np.abs(alone.P).max()
    )
    finer = solved([*CARRIERS, (1, -12)], 32)
    assert np.abs(finer.P[:, 2]).max() > 0.0


def test_rigid_contacts_have_none():
    reduced = rom.reduce(rom.two_mass(beta=0.01), carrier=(0.98, 1.65))
    problem, limit = ContactProblem.of(reduced, rom.Tanh(2.0, 0.02)), np.array([4.0, 2.0])
    assert higher_order_harmonics(problem, Discretisation(64, 8), limit, 1e-6) == {}


def test_a_response_that_is_not_known_is_not_stated_as_zero(monkeypatch, tmp_path):
    def no_convergence(*_):
        raise UnsettledError("contacts: the motion converges at none of the largest amplitudes")

    monkeypatch.setattr("slipmode.rom.table.tabulation.higher_order_harmonics", no_convergence)
    law = rom.Jenkins(2.0, 50.0)
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,), law=law)
    with pytest.warns(rom.ValidityWarning, match="fifth is neglected: .* does not converge"):
        model = rom.tabulate(reduced, law, (4.0,), 1e-2)
    assert model.accuracy.neglected_response == np.inf
    model.save(tmp_path / "model.rom")
    assert rom.Model.load(tmp_path / "model.rom").accuracy == model.accuracy


def test_a_table_that_does_not_settle_with_them_says_what_it_leaves_out():
    case = member(7)
    reduced = rom.reduce(
        case.structure,
        case.modes,
        law=case.law,
        carrier=case.frequency,
        force_patterns=list(case.force),
    )
    steady = rom.steady_state(reduced, case.law, case.frequency, case.force)
    reached = np.abs(np.array(steady.amplitude))
    with pytest.warns(rom.ValidityWarning, match="fifth is neglected: .* by up to ") as warned:
        model = rom.tabulate(reduced, case.law, 2.0 * reached, 1e-2)
    # 0.059 or 0.67: signs of drawn modes, and the phases at which marches start, depend on the
    # threads of OpenBLAS
    assert model.accuracy.neglected_response > 0.05
    assert percentage(model.accuracy.neglected_response) in str(warned[0].message)


def test_two_modes_leave_out_harmonics_that_hardly_matter_and_state_it():
    """Tables without them take half the time (`make bench-table`)."""
    case = jenkins_blade(4)
    reduced, ends = case.reduced.at_carrier(case.frequency), np.array([7.8e-6, 1.03e-5])
    model = rom.tabulate(reduced, case.law, ends.tolist(), 1e-2, detuning=False)
    neglected = model.accuracy.neglected_response
    assert 1e-3 < neglected <= ErrorBudget(1e-2).harmonics  # measured 0.0034
    points = np.random.default_rng(1).random((40, 2)) * ends
    problem = ContactProblem.of(reduced, case.law, highest=15)
    exact = problem.on(Discretisation(128, 32), 1e-5, 0.01 * ends).solve(points).S
    scale = ErrorNorm.of(reduced, ends).known(exact).scale(points, exact)
    error = np.abs(model.table(points) - exact) / scale
    assert error.max() <= model.accuracy.total  # measured 0.0062 and 0.0106


def test_the_change_of_friction_is_found_where_one_mode_is_weak():
    drawn = chain(0)
    reduced = rom.reduce(drawn.structure, drawn.modes, law=drawn.law, carrier=drawn.frequency)
    problem, ends = ContactProblem.of(reduced, drawn.law), np.array(drawn.amplitude_range)
    grid = trial_grid(problem, 1e-2)
    higher = higher_order_harmonics(problem, grid, ends, 5e-4)
    found = change_by_harmonics(problem, higher, grid, ends, 1e-3)
    points = np.array([[1.0, 1.0], [1.0, 0.27]]) * ends
    complete, few = (
        ContactProblem.of(reduced, drawn.law, highest=highest).on(grid, 1e-4).solve(points).S
        for highest in (15, RESPONSE_ORDER)
    )
    scale = ErrorNorm.of(reduced, ends).known(complete).scale(points, complete)
    change = np.abs(complete - few) / scale
    assert found > 0.8 * change.max()  # measured 1.02; 0.45 with pairs up to (1, 0.5)
