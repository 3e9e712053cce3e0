"""Friction tables: surface between the nodes, its ends, energy, range, refusals with advice."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipmode import rom
from slipmode.rom import Coulomb, SlipmodeError, Tanh, reduce, tabulate, two_mass

LIMIT = 2.0
RANGE = (4.0, 4.0)
BOTH = reduce(two_mass())
ALONE = reduce(two_mass(), modes=(0,))

COARSE = {
    "paper, Coulomb": ("paper", Coulomb(LIMIT)),
    "nearly Coulomb": ("consistent", Tanh(LIMIT, 0.01)),
    "strong": ("consistent", Tanh(50.0, 0.1)),
    "no friction": ("consistent", Tanh(0.0, 0.1)),
}


@pytest.fixture(scope="module", params=COARSE)
def coarse_model(request):
    """As few nodes as possible."""
    formulation, law = COARSE[request.param]
    return tabulate(reduce(two_mass(), formulation=formulation), law, RANGE, tolerance=3e-2)


@pytest.mark.oracle
@pytest.mark.quick
def test_slopes_and_twist_of_the_nodes_are_those_of_the_surface_by_differences(two_mode_model):
    table, h = two_mode_model.table, 1e-5
    k, m = 5, 7  # a node inside
    a, b = table.node_a[k], table.node_b[m]
    steps = np.array([[[a + h * i, b + h * j] for j in (-1, 0, 1)] for i in (-1, 0, 1)])
    S = table.terms(steps)
    value, by_a, by_b, twist = table.values[k, m].copy().view(complex)
    np.testing.assert_allclose(S[1, 1], value, rtol=1e-12)
    # the surface has one slope from both sides, and other curvatures
    np.testing.assert_allclose((S[2, 1] - S[0, 1]) / (2 * h), by_a, atol=1e-3 * np.abs(by_a).max())
    np.testing.assert_allclose((S[1, 2] - S[1, 0]) / (2 * h), by_b, atol=1e-3 * np.abs(by_b).max())
    mixed = (S[2, 2] - S[2, 0] - S[0, 2] + S[0, 0]) / (4 * h**2)
    np.testing.assert_allclose(mixed, twist, atol=2e-2 * np.abs(twist).max())
    assert np.abs(twist).max() > 0.0


@pytest.mark.quick
def test_a_mode_at_rest_has_no_friction_term_and_a_mode_alone_is_the_edge(
    two_mode_model, one_mode_model
):
    axis = np.linspace(0, 4, 33)
    rest = np.zeros_like(axis)
    along_A, along_B = (
        two_mode_model.table(np.column_stack(pair)) for pair in ((axis, rest), (rest, axis))
    )
    assert not along_A[:, 1].any() and not along_B[:, 0].any()
    alone = one_mode_model.table(axis[:, np.newaxis])[:, 0]
    stated = two_mode_model.accuracy.total + one_mode_model.accuracy.total
    np.testing.assert_allclose(along_A[:, 0], alone, rtol=0, atol=stated * np.abs(alone).max())


@pytest.mark.oracle
@given(amplitude=st.tuples(st.floats(0, 4), st.floats(0, 4)))
def test_structure_and_friction_never_feed_the_modes_between_the_nodes(coarse_model, amplitude):
    """In the paper's formulation friction alone."""
    reduced, table, a = coarse_model.reduced, coarse_model.table, np.array(amplitude)
    own = reduced.modal_damping * reduced.carrier * (reduced.formulation == "consistent")
    terms = table.terms(a)
    power = 2 * reduced.carrier * a * (own * a - terms[:2].imag)
    assert power.sum() >= -1e-12 * np.abs(power).max()
    # friction alone, to the accuracy of the table: without the part of the dampers
    largest = np.abs(table.nodes()[..., :2]).max(axis=(0, 1))
    leaving = -2 * (reduced.carrier * a) @ terms[:2].imag + terms[-1].real
    most = 2 * reduced.carrier @ (table.amplitude_range * largest)
    assert leaving >= -coarse_model.accuracy.tolerance * most


@pytest.mark.parametrize("modes", [(0,), (0, 1)])
@pytest.mark.parametrize("headroom", [1.0, 1.3])
def test_the_table_ends_at_headroom_times_the_amplitude_and_has_one_hash(modes, headroom):
    """For any number of threads."""
    reduced, law = reduce(two_mass(beta=0.01), modes), Tanh(LIMIT, 0.02)
    amplitude = np.array([3.6, 1.5])[: len(modes)]
    longer = tabulate(reduced, law, amplitude, 1e-2, headroom=headroom, threads=1)
    np.testing.assert_array_equal(longer.table.amplitude_range, headroom * amplitude)
    assert longer.hash == tabulate(reduced, law, headroom * amplitude, 1e-2, threads=3).hash


REFUSED = [
    ({"amplitude": (4.0,)}, "amplitude: must be 2"),
    ({"amplitude": (4.0, 0.0)}, "amplitude: must be 2 finite numbers > 0"),
    ({"tolerance": 0.0}, "tolerance: must be"),
    ({"law": Tanh((1.0, 2.0, 3.0), 0.02)}, "limit: must be one number or 2"),
    ({"budget": 0.0}, r"^budget: must be a finite number > 0 \[s\]"),
    ({"headroom": 0.9}, "headroom: must be a finite number >= 1"),
]


@pytest.mark.quick
@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_refuses_in_one_line(change, message):
    arguments = {"reduced": BOTH, "law": Tanh(LIMIT, 0.02), "amplitude": RANGE, "tolerance": 1e-3}
    with pytest.raises(SlipmodeError, match=message) as refusal:
        tabulate(**(arguments | change))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "law", [Coulomb(LIMIT), pytest.param(Tanh(LIMIT, 1e-3), marks=pytest.mark.slow)]
)
def test_a_tolerance_out_of_reach_is_refused_with_one_that_is_not(law):
    with pytest.raises(SlipmodeError, match="needs more than 8192 steps") as refusal:
        tabulate(ALONE, law, (4.0,), 1e-6)
    advised = float(str(refusal.value).split("a tolerance of ")[1].split()[0])
    assert tabulate(ALONE, law, (4.0,), advised).accuracy.interpolation < advised < 1e-4
    with pytest.raises(SlipmodeError, match=r"^budget: .* a tolerance of "):
        tabulate(ALONE, law, (4.0,), advised, budget=1e-6)


@pytest.mark.slow
def test_a_hopeless_table_ends_by_default():
    """The limit is counted, and reached after one to two minutes."""
    K = 1e4 * (2.0 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1))
    law = rom.Iwan(force=5.0, stiffness=3e3, chi=-0.5, beta=0.5)
    structure = rom.Structure(mass=np.eye(6), stiffness=K, damping=2e-5, contact=[2, 4])
    reduced = rom.reduce(structure, modes=(0, 1), law=law)
    with pytest.raises(SlipmodeError, match=r"budget: the friction table takes more .*one mode"):
        rom.tabulate(reduced, law, (0.02, 0.01), 1e-3)
