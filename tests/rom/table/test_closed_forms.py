"""Friction tables against closed forms: sliders that hardly act on the motion of their mode."""

from functools import cache

import numpy as np
import pytest
from oracles.closed_forms import jenkins_dissipation, jenkins_first_harmonic, play_delay

from slipmode import rom

pytestmark = [pytest.mark.quick, pytest.mark.oracle]

SMALL = 1e-6  # stiffness of weak contacts relative to the structure
LIMITS, STIFFNESSES = np.array([1.0, 0.4]) * SMALL, np.array([1.0, 1.5]) * SMALL
ENDS = (4.0, 2.0)  # largest amplitudes
CARRIER = (1.0, 1.618)


@cache
def weak(modes, tolerance=1e-3):
    """A model whose mode j moves contact j alone."""
    n = len(modes)
    structure = rom.Structure(np.eye(n), np.diag(np.square(CARRIER[:n])), 0.0, contact=np.eye(n))
    law = rom.Jenkins(LIMITS[:n], STIFFNESSES[:n])
    return rom.tabulate(rom.reduce(structure, modes, law=law), law, ENDS[:n], tolerance)


def exact(a):
    """S_j = (k X - q) / 2 of x = X cos(theta), X = 2 a."""
    return np.array(
        [
            [
                0.5 * (k * 2 * each - jenkins_first_harmonic(2 * each, limit, k))
                for each, limit, k in zip(row, LIMITS, STIFFNESSES, strict=False)
            ]
            for row in a
        ]
    )


def drawn(modes, count=300):
    """Amplitudes of all sizes, and just beyond the onset of slip of A."""
    rng = np.random.default_rng(5)
    points = 10.0 ** rng.uniform(-3.0, 0.0, (count, len(modes))) * ENDS[: len(modes)]
    points[: count // 3, 0] = rng.uniform(0.49, 0.55, count // 3)
    return points


@pytest.mark.parametrize(
    ("modes", "tolerance"),
    [
        *(((0,), 1e-2), ((0,), 1e-4), ((0, 1), 1e-2)),
        pytest.param((0, 1), 4e-3, marks=pytest.mark.slow),
    ],
)
def test_the_true_error_is_below_the_stated_one_and_this_below_the_tolerance(modes, tolerance):
    model, points = weak(modes, tolerance), drawn(modes)
    S, accuracy = exact(points), model.accuracy
    floor = (1e-2 if len(modes) == 1 else 1.0) * np.abs(exact([ENDS])).max(axis=0)[: len(modes)]
    rho = (points / ENDS[: len(modes)]).max(axis=1, keepdims=True)
    error = np.abs(model.table(points) - S) / np.maximum(np.abs(S), floor * rho)
    assert error.max() <= accuracy.total
    assert accuracy.interpolation <= tolerance
    assert error.max() > 1e-2 * accuracy.total


def test_slopes_at_the_nodes_are_those_of_the_closed_form():
    """Of a cell of width h, an error e of a slope changes the surface by 4 / 27 h e."""
    model, step = weak((0,), 1e-4), 1e-6
    node = model.table.node_a
    inner = node[1:-1, np.newaxis]
    slope = (exact(inner + step) - exact(inner - step))[:, 0] / (2.0 * step)
    found = model.table.values[1:-1, 0, 1].copy().view(complex)[:, 0]
    h = np.minimum(np.diff(node)[1:], np.diff(node)[:-1])
    scale = np.maximum(np.abs(exact(inner)[:, 0]), 1e-2 * np.abs(exact([ENDS])[0, 0]))
    assert np.all(np.abs(found - slope) * h * 4.0 / 27.0 <= 2.0 * model.accuracy.total * scale)


@pytest.mark.parametrize("tolerance", [1e-2, pytest.param(4e-3, marks=pytest.mark.slow)])
def test_powers_of_the_table_are_what_sliders_dissipate(tolerance):
    model, points = weak((0, 1), tolerance), drawn((0, 1))
    most = 2.0 * model.accuracy.total * np.abs(exact([ENDS])[0]) * ENDS @ CARRIER
    lost = sum(
        Omega / (2.0 * np.pi) * np.array([jenkins_dissipation(2 * a, mu_N, k) for a in column])
        for Omega, column, mu_N, k in zip(CARRIER, points.T, LIMITS, STIFFNESSES, strict=True)
    )
    leaving = -2.0 * (points * model.table(points).imag) @ CARRIER
    np.testing.assert_allclose(leaving, lost, rtol=0, atol=most)
    np.testing.assert_allclose(model.table.terms(points)[:, -1].real, 0.0, atol=most)


def test_the_rate_correction_is_that_of_the_play_operator():
    """After a reversal a slider holds the peak of then, which has grown since."""
    model = weak((0,))
    a, k, limit = model.table.node_a[1:-1], STIFFNESSES[0], LIMITS[0]
    a = a[(a > 1.05 * 0.5 * limit / k) & (a < 0.9 * ENDS[0])]
    found = model.table.rate_correction_at(a[:, np.newaxis])[:, 0, 0]
    for each, R in zip(a, found, strict=True):
        stick = np.arccos(1.0 - limit / (k * each))
        play = -2.0 * k * play_delay(stick) / (np.pi * CARRIER[0])
        assert pytest.approx(play, abs=4e-3 * k) == R


# Joints


@pytest.mark.parametrize("damping", [1e-3, 0.0])
def test_a_joint_is_damped_as_its_hysteresis_says(damping):
    """Energy of a cycle of motion X: pi gamma Omega X^2 + E(X), of Iwan's distribution."""
    K, M = np.diag([1.0, 400.0]), np.eye(2)
    law = rom.Iwan(force=0.02, stiffness=0.05, chi=-0.5, beta=0.3)
    reduced = rom.reduce(rom.Structure(M, K, damping * M, contact=(0,)), (0,), law=law)
    amplitude = np.geomspace(2e-3, 0.396, 60)
    curve = rom.backbone(rom.tabulate(reduced, law, (0.4,), warned=False), amplitude=amplitude)
    share = law.beta + (law.chi + 1.0) / (law.chi + 2.0)
    largest = law.force * (1.0 + law.beta) / (law.stiffness * share)
    R, X = law.force * (law.chi + 1.0) / (largest ** (law.chi + 2.0) * share), 2.0 * amplitude
    assert X.max() < 1.01 * largest
    lost = 4.0 * R * X ** (law.chi + 3.0) / (law.chi + 2.0) / (law.chi + 3.0)
    # structural part of 2 zeta Omega^2 |a|, and the part of the joint: E = 2 pi zeta_joint k X^2
    zeta = 0.5 * damping / curve.frequency + lost / (2.0 * np.pi * (curve.frequency * X) ** 2)
    # 1 % is what six or more sliders lack of the distribution
    assert np.all(np.abs(curve.damping / zeta - 1.0) <= 0.01)


def test_where_contacts_stick_the_backbone_is_linear():
    law = rom.Jenkins(limit=2.0, stiffness=20.0)
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,), law=law)
    onset = 2.0 / float(np.abs(2.0 * reduced.coupling[0] * 20.0).max())
    model = rom.tabulate(reduced, law, (5.0 * onset,), warned=False)
    curve = rom.backbone(model, amplitude=np.geomspace(0.01, 0.99, 30) * onset)
    linear = 0.5 * reduced.modal_damping[0] / reduced.frequency[0]
    np.testing.assert_allclose(curve.frequency, reduced.frequency[0], rtol=1e-5)
    np.testing.assert_allclose(curve.damping, linear, rtol=1e-3)


@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_where_contacts_stick_dampers_between_modes_act():
    """Unequal dampers: the second and third mode move with the first, and act on it."""
    K, C, spring = [[200.0, -100.0, 0.0], [-100.0, 250.0, -100.0], [0.0, -100.0, 200.0]], 2.0, 30.0
    law, damper = rom.Jenkins(1.0, spring), np.diag([C, 0.0, 0.1 * C])
    structure = rom.Structure(np.eye(3), K, damper, contact=[2])
    reduced = rom.reduce(structure, (0,), law=law)
    model, omega = rom.tabulate(reduced, law, (0.5,)), 1.02 * reduced.frequency[0]
    assert model.accuracy.interpolation <= 1e-3
    stuck = K + np.diag([0.0, 0.0, spring]) - omega**2 * np.eye(3) + 1j * omega * damper
    expected = 0.5 * reduced.mode_shapes[:, 0] @ np.linalg.solve(stuck, [0.2, 0.0, 0.0])
    found = rom.steady(model, [omega], [{0: 0.2}])[0]
    assert abs(found / expected - 1.0) < 1e-6
