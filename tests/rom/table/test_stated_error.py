"""The error that a table states is not below its true one.

The reference solves the contact problem with harmonics up to the 15th in at least twice the
steps (tests/rom/contact/test_against_oracles.py compares it with time integration), at drawn
amplitudes of 0.1 % to 100 % of the range, and just past the onset of slip.
"""

import numpy as np
import pytest
from elastic.cantilever import LAWS, cantilever
from evidence.answers import reduced as family_reduced
from oracles.families import case

from slipmode import rom
from slipmode.rom import ContactProblem, Coulomb, Discretisation, Tanh

IWAN = rom.Contacts(
    [
        (rom.Iwan(0.4, 20.0, -0.5, 0.5, sliders=6), (0,)),
        (rom.Jenkins((0.2, 0.02), (20.0, 10.0)), (1, 2)),
        (rom.Iwan(0.05, 8.0, -0.5, 0.5, sliders=6), (3,)),
    ]
)
ONSET = np.array([1.0, 1 / 2.89])  # of A and B alone, of the two-mass structure


def drawn(limit, onset=None, count=200):
    """Points in the order in which contacts with two motions are followed from small ones."""
    rng = np.random.default_rng(7)
    points = 10.0 ** -rng.uniform(0.0, 3.0, (count, limit.size)) * limit
    points[: count // 4] = rng.random((count // 4, limit.size)) * limit
    if onset is not None:
        for j in range(limit.size):
            past = rng.uniform(0.97, 1.1, (count // 4, 1)) * onset[j]
            beside = rng.random((count // 4, limit.size)) * limit
            beside[:, j : j + 1] = past
            points = np.vstack((points, beside))
    points = points[(points <= limit).all(axis=1) & ((points / limit).max(axis=1) > 1e-3)]
    return points[np.lexsort(points.T[::-1])]


def check(reduced, law, amplitude, tolerance, onset=None, within=1.0, highest=15):
    """Compare stated and true error; the stated one may be `within` times the tolerance."""
    limit = np.array(amplitude)
    model = rom.tabulate(
        reduced, law, amplitude, tolerance, detuning=False, warned=False, budget=1800.0
    )
    reduced, accuracy, points = model.reduced, model.accuracy, drawn(limit, onset)
    problem = ContactProblem.of(reduced, law, model.combinations, highest)
    few = limit.size == 1
    grid = Discretisation((4 if few else 2) * accuracy.steps, 1 if few else 32)
    march = (1e-3 if few else 0.1) * tolerance
    torus = problem.on(grid, march, 1e-3 * limit)
    terms = torus.on_more_lines(torus.solve(points))
    known = terms.residual <= march
    assert known.mean() > 0.75  # the others have no reference
    loss = reduced.modal_damping * reduced.carrier
    largest = np.abs(model.table.nodes()[..., : limit.size]).max(axis=(0, 1))
    rho = (points / limit).max(axis=1, keepdims=True)
    floor = {1: 1e-2, 2: 1.0}[limit.size] * largest * rho
    scale = np.maximum(np.abs(terms.S) + loss * points, floor)
    error = (np.abs(model.table(points) - terms.S) / scale)[known].max()
    assert error <= accuracy.total
    assert accuracy.interpolation <= within * tolerance
    assert error > 1e-3 * accuracy.total


@pytest.mark.parametrize(
    ("law", "amplitude", "tolerance"),
    [
        (Coulomb(2.0), (4.0,), 1e-3),
        pytest.param(
            *(Coulomb(2.0), (4.0,), 1e-5),
            marks=pytest.mark.xfail(strict=True, reason="true 3.5e-5, stated 6.9e-6"),
        ),
        (Tanh(2.0, 0.005), (4.0,), 1e-3),
        (Tanh(2.0, 0.1), (4.0,), 1e-4),
        (Coulomb(2.0), (3.6, 1.5), 1e-2),
        pytest.param(Tanh(2.0, 0.02), (4.0, 2.0), 1e-3, marks=pytest.mark.slow),
        # whose onset midpoints of the range pass beside
        pytest.param(
            *(Tanh(2.0, 0.002), (1.4, 0.13), 1e-3),
            marks=[
                pytest.mark.slow,
                pytest.mark.xfail(strict=True, reason="true 1.11e-3, stated 1.06e-3"),
            ],
        ),
    ],
)
def test_of_rigid_contacts(law, amplitude, tolerance):
    modes = len(amplitude)
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0, 1)[:modes], carrier=(0.98, 1.65)[:modes])
    check(reduced, law, amplitude, tolerance, ONSET)


@pytest.mark.parametrize(
    # with the gap there are two motions at some amplitudes, 1.3e-3 apart
    ("law", "modes", "tolerance"),
    [
        (LAWS["with a gap"], (0,), 5e-3),
        (IWAN, (0,), 1e-3),
        *(
            pytest.param(law, (0, 1), 1e-2, marks=pytest.mark.slow)
            for law in (*LAWS.values(), IWAN)
        ),
        *(pytest.param(law, (0,), 1e-3, marks=pytest.mark.slow) for law in LAWS.values()),
    ],
)
def test_of_elastic_contacts(law, modes, tolerance):
    reduced = rom.reduce(cantilever(law), modes, law=law)
    check(reduced, law, (0.03, 0.02)[: len(modes)], tolerance, within=2.0)


FAMILY = [
    (3, 2, None),
    *((1, 1, 7.0), (2, 1, 7.0)),  # a mode near the seventh harmonic of the contacts
    # a quarter of the reference solutions of seed 6 do not converge
    *(pytest.param(seed, 2, None, marks=pytest.mark.slow) for seed in (0, 4, 5, *range(7, 12))),
    *(pytest.param(seed, 2, 3.0, marks=pytest.mark.slow) for seed in range(3)),
]


@pytest.mark.parametrize(("seed", "modes", "ratio"), FAMILY)
def test_of_drawn_structures_whose_modes_respond_to_higher_order_harmonics(seed, modes, ratio):
    """Tables of two modes leave out what hardly matters, and state it."""
    given = case(seed, modes, ("Jenkins", "Iwan"), ratio, shares=(0.1, 0.3))
    reduced, law = family_reduced(given, forced=False)
    check(reduced, law, tuple(1.2 * np.array(given.amplitude)), 1e-2, within=2.0)


@pytest.mark.slow
@pytest.mark.parametrize("law", [Coulomb((2.0, 1.0)), Tanh((2.0, 1.0), 0.02)], ids=str)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
@pytest.mark.parametrize("seed", [0, 1, 4])
def test_of_drawn_stiffness_and_damping(seed, law, tolerance):
    rng = np.random.default_rng(seed)
    stiff, weak = rng.uniform(10, 60, 2), rng.uniform(1, 8)
    body = rom.two_mass(beta=rng.uniform(0.002, 0.02), k_c1=stiff[0], k_c2=stiff[1], k_p=weak)
    # samples of Coulomb friction jump where contacts begin to slip
    jumps = isinstance(law, Coulomb) and tolerance < 1e-2
    check(rom.reduce(body), law, (4.0, 2.0), tolerance, within=3.0 if jumps else 1.0)


@pytest.mark.slow
def test_friction_that_jumps_is_tabulated_and_the_jump_is_stated():
    """Near |a| = 0.0118 the contacts come to one of two motions, S differs by 0.1 to 0.6 %."""
    law = LAWS["mixed"]
    reduced = rom.reduce(cantilever(law), (1,), law=law)
    with pytest.warns(rom.ValidityWarning, match="misses its tolerance: its relative error is"):
        model = rom.tabulate(reduced, law, (0.03,), 1e-3)
    assert model.accuracy.interpolation > 1e-3
