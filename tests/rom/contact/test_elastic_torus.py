"""The torus of elastic contacts: closed phase lines, turning points between steps, starts."""

from dataclasses import replace

import numpy as np
import pytest
from elastic.frictional_beam import ROWS, structure

from benchmarks.blade import jenkins_blade
from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation, SlipmodeError, combination_resonances
from slipmode.rom.contact.higher_order_harmonics import higher_order_harmonics
from slipmode.rom.contact.torus.grid import closed_lines, step_counts
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.reduction.nonresonant import with_responding

LIFT_OFF, SLIDER = ROWS[1], ROWS[4]


def terms(row, grid, tolerance, parts=((1.0, 1.0),)):
    reduced = rom.reduce(structure(row.law, row.node), (0, 1), law=row.law)
    combinations = combination_resonances(reduced.carrier, even=reduced.even)
    largest = 1.1 * np.abs(row.amplitude)
    points = np.array(parts) * largest
    return (
        ContactProblem.of(reduced, row.law, combinations)
        .on(grid, tolerance, 0.1 * largest)
        .solve(points)
    )


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize("ratio", [3.446, 2.6656, 1.0 + 1e-3, 0.37, 17.2])
def test_a_period_takes_each_line_to_where_another_was(ratio, odd):
    lines, closed = closed_lines(ratio, 16, 1e-3, odd=odd)
    assert 16 <= lines <= 32
    assert (closed * lines) % 1.0 == pytest.approx(0.0, abs=1e-12)
    assert abs(closed - ratio) <= 0.5 / 16


def test_lines_are_more_where_that_saves_half_a_period():
    assert closed_lines(2.94, 16, 1e-2, odd=False) == (16, 47 / 16)
    assert closed_lines(2.94, 16, 1e-2, odd=True) == (23, 67 / 23)


@pytest.mark.parametrize(
    ("law", "modes"),
    [
        (rom.Jenkins(0.4, 40.0), (0,)),
        (rom.Jenkins(0.4, 40.0), (0, 1)),
        (rom.Iwan(0.4, 40.0, chi=-0.5, beta=1.0), (0,)),
    ],
)
def test_half_a_period_of_sliders_tells_the_other(law, modes):
    """An even harmonic, which they do not have, makes it march whole ones."""
    reduced = rom.reduce(structure(law, 5), modes, law=law)
    largest = np.array([0.02, 0.012])[: len(modes)]
    points = np.array([[1.0, 1.0], [0.5, 0.7], [0.8, 0.2]])[:, : len(modes)] * largest

    def half_and_whole(tolerance):
        return [
            ContactProblem.of(reduced, law, higher_orders=orders)
            .on(Discretisation(64, 16), tolerance)
            .solve(points)
            for orders in ([], [(2, 0)])
        ]

    half, whole = half_and_whole(1e-4)
    assert half.marched.sum() < 0.8 * whole.marched.sum()
    half, whole = half_and_whole(1e-7)
    np.testing.assert_allclose(half.S, whole.S, atol=1e-5 * np.abs(whole.S).max())


@pytest.mark.parametrize("row", [LIFT_OFF, SLIDER], ids=["lift-off", "slider"])
def test_the_motion_repeats_as_closely_as_is_asked(row):
    """Drifting lines ended at the error of the grid, after the most periods that are allowed."""
    found = terms(row, Discretisation(64, 16), 1e-7)
    assert found.residual.max() <= 1e-7
    assert found.marched.max() <= 40 * 64  # measured 19 and 9 periods


def test_a_slider_that_moves_for_parts_of_steps_is_of_third_order():
    """It begins to slide, and turns back, between them."""
    steps = np.array([64, 128, 256])
    exact = terms(SLIDER, Discretisation(1024, 16), 1e-8).S
    errors = [np.abs(terms(SLIDER, Discretisation(n, 16), 1e-8).S - exact).max() for n in steps]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 2.6  # 2.0 from step to step
    # measured: 1.3e-4; 1.4e-3 where the way of the contact itself told where it turned back
    assert errors[1] < 3e-4 * np.abs(exact).max()


def test_a_point_after_another_is_what_it_is_alone():
    grid, parts = Discretisation(64, 16), ((0.5, 1.0), (0.6, 1.0), (0.7, 1.0))
    together = terms(LIFT_OFF, grid, 1e-7, parts)
    alone = [terms(LIFT_OFF, grid, 1e-7, (part,)) for part in parts]
    exact = np.array([one.S[0] for one in alone])
    np.testing.assert_allclose(together.S, exact, atol=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("row", "part"), [(LIFT_OFF, 0.8), (SLIDER, 0.8)], ids=["lift-off", "slider"]
)
def test_a_point_that_begins_with_harmonics_nearby_is_what_it_is_alone(row, part):
    """And no later; harmonics that are nothing like its own do no harm."""
    reduced = rom.reduce(structure(row.law, row.node), (0, 1), law=row.law)
    largest = 1.1 * np.abs(row.amplitude)
    points, grid = np.array([[0.8, 0.9], [1.0, 0.9]]) * largest, Discretisation(64, 16)

    resonances = combination_resonances(reduced.carrier, even=reduced.even)
    solve = ContactProblem.of(reduced, row.law, resonances).on(grid, 1e-5, 0.1 * largest).solve

    alone = solve(points)
    sooner = solve(points, solve(0.99 * points).P)
    assert sooner.marched.sum() <= part * alone.marched.sum()
    for found in (sooner, solve(points, 10.0 * alone.P.conj())):
        assert found.residual.max() <= 1e-5
        np.testing.assert_allclose(found.S, alone.S, atol=1e-3 * np.abs(alone.S).max())


def test_steps_are_many_enough_for_the_faster_carrier():
    assert step_counts(np.array([2.0, 5.0]), 32) == (32, 64, 128, 256, 512, 1024, 2048)
    assert step_counts(np.array([2.0]), 1024) == (1024, 2048, 4096, 8192, 16384)
    counts = step_counts(np.array([1.0, 542.0]), 128)
    assert counts == (4096, 8192, 16384, 32768, 65536)


def test_harmonics_that_nothing_asks_for_need_not_repeat():
    """A contact that slips on a few phase lines has some that move for ever, modes or none."""
    case = jenkins_blade(12)
    few, _ = with_responding(replace(case.reduced, force_patterns=None), 5e-3)
    reduced, largest, grid = (
        few.at_carrier(case.frequency),
        np.array([4.895e-6, 7.752e-6]),
        Discretisation(64, 16),
    )
    problem = ContactProblem.of(reduced, case.law)
    higher = higher_order_harmonics(problem, grid, largest, ErrorBudget(1e-2).response)
    problem = ContactProblem.of(reduced, case.law, higher_orders=list(higher))
    point, tolerance = [np.array([3.4, 5.2]) / 7.0 * largest], 1e-3

    def solved(requested):
        torus = replace(problem, requested=requested).on(grid, tolerance, 0.1 * largest)
        return torus.solve(point)

    every, carriers = solved(0), solved(2)
    assert every.marched[0] > 3 * carriers.marched[0]  # measured 3.6
    off = np.abs(carriers.P - every.P).max(axis=2)[0] / np.abs(every.P).max()
    assert off[:2].max() <= 2.0 * tolerance
    assert off.max() <= 1.2e-2  # measured 1.1e-2
    with pytest.raises(SlipmodeError):
        solved(len(problem.orders) + 1)
