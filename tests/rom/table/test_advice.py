"""Advice that comes with a refusal works when it is followed."""

import pytest

from slipmode import rom
from slipmode.rom.table.refinement import refine as refinement

TOO_FINE = 1e-6


def advised(refusal):
    return float(str(refusal.value).split("a tolerance of ")[1].split()[0])


@pytest.mark.parametrize("law", [rom.Coulomb(2.0), rom.Tanh(2.0, 1e-3)])
def test_a_contact_problem_that_cannot_be_resolved_names_a_tolerance_that_can(law):
    reduced = rom.reduce(rom.two_mass(), (0,))
    with pytest.raises(rom.SlipmodeError, match="needs more than 1024 steps") as refusal:
        rom.tabulate(reduced, law, (4.0,), TOO_FINE)
    model = rom.tabulate(reduced, law, (4.0,), advised(refusal))
    assert model.accuracy.interpolation < advised(refusal) < 100 * TOO_FINE


def test_a_table_that_grows_too_large_names_a_tolerance_that_does_not(monkeypatch):
    monkeypatch.setattr(refinement, "_MOST_NODES", 500)
    reduced = rom.reduce(rom.two_mass())
    with pytest.raises(rom.SlipmodeError, match=r"needs more than \d+ x \d+ nodes") as refusal:
        rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), 3e-4)
    model = rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), advised(refusal))
    assert model.accuracy.interpolation < advised(refusal) < 0.01
