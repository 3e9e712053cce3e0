"""Contacts that are soft against the modes that respond to them: solved, or refused with why."""

import numpy as np
import pytest
from elastic.family import blade

from slipmode import rom
from slipmode.rom import SlipmodeError, Tanh, full
from slipmode.rom.reduction.reaction import stiffness_loss

LAW = Tanh(2.0, 0.02)
FREQUENCY = (0.98, 1.65)


def softened(factor):
    return rom.two_mass(k_c1=20 / factor, k_c2=40 / factor, k_p=5 / factor)


def reduced(factor):
    return rom.reduce(softened(factor)).at_carrier(FREQUENCY)


@pytest.mark.quick
def test_all_stiffness_is_lost_where_the_free_contacts_resonate_with_the_mode_held():
    """Mode A held, modes and contacts together have a natural frequency at its carrier."""
    factor = 27.4
    share, order = stiffness_loss(reduced(factor))
    structure = rom.two_mass(k_c1=20 / factor, k_c2=40 / factor, k_p=5 / factor, contact_mass=1e-9)
    held = np.ix_([1, 2, 3], [1, 2, 3])  # x_e1 is mode A
    squares = np.linalg.eigvals(np.linalg.solve(structure.mass[held], structure.stiffness[held]))
    assert order == (1, 0)
    assert share == pytest.approx(1.0, abs=0.01)
    assert np.sqrt(squares.real.min()) == pytest.approx(0.98, rel=0.01)


@pytest.mark.quick
def test_stiff_contacts_are_not_soft():
    share, _ = stiffness_loss(reduced(1))
    assert share == pytest.approx(0.104, abs=0.001)


@pytest.mark.parametrize(
    ("factor", "loss", "tolerance"),
    [
        (15, 0.79, 2e-2),
        pytest.param(15, 0.79, 3e-3, marks=pytest.mark.slow),
        pytest.param(100, 1.32, 2e-2, marks=pytest.mark.slow),
    ],
)
def test_a_table_of_soft_contacts_is_as_exact_as_it_was_asked_to_be(factor, loss, tolerance):
    """Also where modes take away all the stiffness of the contacts, and friction alone holds."""
    assert stiffness_loss(reduced(factor))[0] == pytest.approx(loss, abs=0.01)
    model = rom.tabulate(reduced(factor), LAW, (1.2, 0.45), tolerance)
    force = ({0: 0.05}, {1: 0.08})
    structure, shapes = softened(factor), model.reduced.mode_shapes
    expected = full.steady_amplitude(
        structure,
        LAW,
        full.Excitation.harmonic(structure, force, FREQUENCY),
        outputs=shapes.T @ structure.mass,
        tolerance=3e-4,
    ).amplitude
    found = rom.steady(model, FREQUENCY, force)
    assert np.abs(found / np.diagonal(expected) - 1.0).max() <= tolerance


@pytest.mark.quick
def test_a_response_that_does_not_settle_is_refused_with_mode_harmonic_and_what_would_help():
    """Two modes of a mesh that friction holds at a node; a third mode is near a third multiple."""
    M, K = (matrix[10:, 10:] for matrix in blade(14, 4))
    W = np.zeros((len(M), 1))
    W[2 * 53, 0] = 1.0
    bound = rom.reduce(rom.Structure(M, K, 1e-3, contact=W))
    slipping = 3.0 / np.linalg.norm(bound.spring, axis=1)
    refusal = (
        r"at 3.\d+ rad/s responds most, to harmonic \(0, 3\) at 3.\d+ rad/s; "
        "let contacts be elastic"
    )
    with pytest.raises(SlipmodeError, match=refusal) as refused:
        rom.tabulate(bound, rom.Coulomb(1.0), slipping, 1e-2)
    assert "\n" not in str(refused.value)
