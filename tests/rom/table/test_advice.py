"""Advice that comes with a refusal works when it is followed."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.error_budget import within_reach
from slipmode.rom.table.refinement import refine as refinement

TOO_FINE = 1e-6


def advised(refusal):
    return float(str(refusal.value).split("a tolerance of ")[1].split()[0])


@pytest.mark.parametrize(
    "law", [rom.Coulomb(2.0), pytest.param(rom.Tanh(2.0, 1e-3), marks=pytest.mark.slow)]
)
def test_a_contact_problem_that_cannot_be_resolved_names_a_tolerance_that_can(law):
    reduced = rom.reduce(rom.two_mass(), (0,))
    with pytest.raises(rom.SlipmodeError, match="needs more than 8192 steps") as refusal:
        rom.tabulate(reduced, law, (4.0,), TOO_FINE)
    model = rom.tabulate(reduced, law, (4.0,), advised(refusal))
    assert model.accuracy.interpolation < advised(refusal) < 100 * TOO_FINE


def test_a_table_that_grows_too_large_names_a_tolerance_that_does_not(monkeypatch):
    monkeypatch.setitem(refinement._MOST_SAMPLES, 2, 500)
    reduced = rom.reduce(rom.two_mass())
    with pytest.raises(rom.SlipmodeError, match=r"needs more than \d+ x \d+ nodes") as refusal:
        rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), 3e-4)
    model = rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), advised(refusal))
    assert model.accuracy.interpolation < advised(refusal) < 0.01


@pytest.mark.parametrize(
    ("modes", "tolerance", "looks", "taken"),
    [((0,), 1e-5, 0, "steps or phase lines"), ((0, 1), 3e-4, 5, "nodes of that time")],
)
def test_a_table_that_takes_too_long_names_a_tolerance_that_does_not(
    monkeypatch, modes, tolerance, looks, taken
):
    """The clock is asked after each trial of the grid, and each time that cells are halved."""
    left = [looks]

    def spent(_):
        left[0] -= 1
        return left[0] < 0

    reduced, law = rom.reduce(rom.two_mass(), modes), rom.Tanh(2.0, 0.02)
    reach = (4.0, 2.0)[: len(modes)]
    with monkeypatch.context() as patch:
        patch.setattr(TimeBudget, "spent", property(spent))
        with pytest.raises(rom.SlipmodeError, match=rf"^budget: .*{taken}") as late:
            rom.tabulate(reduced, law, reach, tolerance, budget=60.0)
    model = rom.tabulate(reduced, law, reach, advised(late), budget=60.0)
    assert model.accuracy.interpolation < advised(late) < 0.1


@pytest.mark.parametrize("budget", [0.0, -1.0, np.inf])
def test_a_budget_is_seconds(budget):
    with pytest.raises(rom.SlipmodeError, match=r"^budget: must be a finite number > 0 \[s\]"):
        rom.tabulate(rom.reduce(rom.two_mass(), (0,)), rom.Coulomb(2.0), (4.0,), budget=budget)


def test_no_advice_goes_beyond_what_is_allowed():
    assert within_reach(0.05) == "a tolerance of 0.05 is within reach"
    assert "rom.full" in within_reach(0.2)
