"""Contacts that are too soft for the method are refused before any work."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import SlipmodeError, Tanh
from slipmode.rom.reduction.stiffness_margin import check_stiffness_margin, stiffness_loss

pytestmark = pytest.mark.quick

LAW = Tanh(2.0, 0.02)


def softened(factor):
    structure = rom.two_mass(k_c1=20 / factor, k_c2=40 / factor, k_p=5 / factor)
    return rom.reduce(structure).at_carrier((0.98, 1.65))


def test_all_stiffness_is_lost_where_the_free_contacts_resonate_with_the_mode_held():
    """Mode A held, modes and contacts together have a natural frequency at its carrier."""
    factor = 27.4
    share, order = stiffness_loss(softened(factor))
    structure = rom.two_mass(k_c1=20 / factor, k_c2=40 / factor, k_p=5 / factor, contact_mass=1e-9)
    held = np.ix_([1, 2, 3], [1, 2, 3])  # x_e1 is mode A
    squares = np.linalg.eigvals(np.linalg.solve(structure.mass[held], structure.stiffness[held]))
    assert order == (1, 0)
    assert share == pytest.approx(1.0, abs=0.01)
    assert np.sqrt(squares.real.min()) == pytest.approx(0.98, rel=0.01)


def test_stiff_contacts_are_not_soft():
    share, _ = stiffness_loss(softened(1))
    assert share == pytest.approx(0.104, abs=0.001)


@pytest.mark.parametrize(
    ("factor", "tolerance", "message"),
    [
        (15, 3e-3, "take away 79% of their stiffness, allowed: 75%; use a tolerance of 0.02, "),
        (
            100,
            2e-2,
            "take away 132% of their stiffness, allowed: 110%; use contacts that are",
        ),
    ],
)
def test_soft_contacts_are_refused_in_one_line(factor, tolerance, message):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        rom.tabulate(softened(factor), LAW, (1.2, 0.45), tolerance)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("factor", [15, pytest.param(30, marks=pytest.mark.slow)])
def test_soft_contacts_are_allowed_the_table_that_is_advised(factor):
    rom.tabulate(softened(factor), LAW, (1.2, 0.45), 2e-2)


@pytest.mark.parametrize("factor", [15, 100])
def test_springs_that_are_advised_are_enough(factor):
    with pytest.raises(SlipmodeError) as refusal:
        rom.tabulate(softened(factor), LAW, (1.2, 0.45), 3e-3)
    springs = float(str(refusal.value).split("stiffer by ")[1].split()[0])

    def reduced(more):
        k_c1, k_c2 = (k / factor + more for k in (20, 40))
        structure = rom.two_mass(k_c1=k_c1, k_c2=k_c2, k_p=5 / factor)
        return rom.reduce(structure).at_carrier((0.98, 1.65))

    check_stiffness_margin(reduced(springs), 3e-3)
    with pytest.raises(SlipmodeError):
        check_stiffness_margin(reduced(0.9 * springs), 3e-3)
