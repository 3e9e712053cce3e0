"""Curves and steady states in which a harmonic of friction meets another mode."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from evidence.answers import (
    MODE_SLIDERS,
    amplitudes,
    forces,
    limited,
    reduced,
    solution,
    structure_and_law,
)
from oracles.families import case
from oracles.harmonic_balance import balance

from slipmode import fmu, rom

pytestmark = pytest.mark.oracle

PUBLISHED = Path(__file__).parents[5] / "shared/data/published/iwan3dof_1to3_reference.csv"


@pytest.fixture(scope="module")
def iwan():
    """Structure and law of a published resonance 1:3, and its values by harmonic balance."""
    if not PUBLISHED.exists():
        pytest.skip("published data are absent")
    inverse = np.linalg.inv(np.array([[1.0, 2.0, -2.0], [2.0, 1.0, 1.0], [3.0, -1.0, 1.0]]))
    M, w = inverse.T @ inverse, np.array([0.0, 1.0, -1.0])
    K = inverse.T @ np.diag([1.0, 9.0, 56.25]) @ inverse - 0.3 * np.outer(w, w)
    structure = rom.Structure(M, K, 0.01 * M, contact=w[:, np.newaxis])
    law = rom.Iwan(10.0, 0.6, -0.5, 0.0)
    return structure, law, np.loadtxt(PUBLISHED, delimiter=",", skiprows=2)


@pytest.mark.slow
@pytest.mark.parametrize("force", [1.0, 2.0])
@pytest.mark.parametrize("on_one_tone", [False, True])
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_the_published_resonance_1_to_3_of_an_iwan_joint(iwan, force, on_one_tone):
    """The third harmonic of mode A is 7 % below to 5 % above mode B, retained or not."""
    structure, law, data = iwan
    options = {"ratio": 3, "carrier": [1.01]} if on_one_tone else {}
    modes, tolerance = ((0, 1), 3e-3) if on_one_tone else ((0,), 1e-2)
    small = rom.reduce(structure, modes, law=law, force_patterns=[{0: 1.0}], **options)
    model = rom.tabulate(small, law, (16.0,) if on_one_tone else (30.0,), tolerance)
    curve = rom.response_curve(model, [1.0], [{0: force}], "frequency_A", (0.97, 1.05))
    size, Omega = curve.displacement(0)[:, 0], curve.parameter
    for _, at, given, _ in data[data[:, 0] == force]:
        apart = Omega - at  # the curve passes the frequency between these points
        (k,) = np.nonzero((apart[:-1] * apart[1:] <= 0.0) & (np.diff(curve.branch) == 0))
        part = apart[k] / (apart[k] - apart[k + 1])
        found = size[k] + part * (size[k + 1] - size[k])
        assert np.abs(found / given - 1.0).min() < 5e-3
        if on_one_tone:
            assert (
                np.abs(from_rest(model, at, {0: force}) - curve.at(at)[0]).min()
                < 5e-3 * size.max()
            )


def from_rest(model, Omega, force):
    """Amplitudes after 300 decay times under a constant force."""
    component = fmu.Component(model, [force], warned=False)
    component.set_inputs(force_A=1.0, frequency_A=Omega)
    component.do_step(0.0, 600.0 / model.reduced.modal_damping[0])
    outputs = component.outputs()
    return np.array([outputs[f"{mode}_re"] + 1j * outputs[f"{mode}_im"] for mode in "AB"])


@pytest.mark.parametrize(
    ("seed", "share", "error"),
    [
        (3, 0.03, 2e-3),
        pytest.param(1, 0.25, 1e-2, marks=pytest.mark.slow),
        pytest.param(0, 0.1, 8e-3, marks=pytest.mark.slow),
        pytest.param(2, 0.25, 1e-2, marks=pytest.mark.slow),
    ],
)
def test_modes_on_one_tone_by_harmonic_balance(seed, share, error):
    """From rest within 0.2, 0.8 and 1 % where contacts are 3, 10 and 25 % of the stiffness."""
    given = case(seed, 1, MODE_SLIDERS, 3.0, 1e-3, (share, 1.001 * share))
    (tone,), s = given.tones, given.system
    structure, law, _ = structure_and_law(given)
    stuck = s.K + (s.W * [joint.stuck for joint in s.laws]) @ s.W.T
    omega = np.sqrt(scipy.linalg.eigh(stuck, s.M, eigvals_only=True))
    modes = (*given.modes, int(np.abs(omega - 3.0 * tone.Omega).argmin()))
    options = {"ratio": 3, "carrier": [tone.Omega], "force_patterns": [tone.F.real]}
    small = rom.reduce(structure, modes, law=law, warned=False, **options)
    harmonics = balance(s, tone.Omega, tone.F)
    true = 0.5 * small.mode_shapes.T @ s.M @ np.transpose([harmonics[1], harmonics[3]])
    model = rom.tabulate(small, law, (1.4 * abs(true[0, 0]),), 5e-3)
    found = from_rest(model, tone.Omega, tone.F.real)
    assert np.abs(found - np.diag(true)).max() < error * abs(true[0, 0])


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [2.99, 2.02, 1.04])
@pytest.mark.parametrize(
    ("seed", "shares", "error"), [(1, 0.03, 5e-3), (2, 0.1, 1e-2), (3, 0.25, 2e-2)]
)
def test_two_modes_near_a_ratio_of_integers(ratio, seed, shares, error):
    """The contacts take 3, 10 and 25 % of the stiffness of mode A."""
    given = case(seed, 2, ("Jenkins", "Iwan"), ratio, shares=(0.9 * shares, 1.1 * shares))
    exact = solution(given)
    small, law = reduced(given)
    true, own = amplitudes(given, small, exact)
    Omega = [tone.Omega for tone in given.tones]
    model = limited(lambda: rom.tabulate(small, law, (1.3 * np.abs(true)).tolist(), 5e-3), 200.0)
    found = limited(lambda: rom.steady(model, Omega, forces(given)), 200.0)
    assert (np.abs(found - true) <= error * np.abs(true) + own).all()


@pytest.mark.parametrize(
    ("seed", "distance"), [(1, -0.003), pytest.param(0, 0.003, marks=pytest.mark.slow)]
)
def test_backbones_by_harmonic_balance(seed, distance):
    """A force a quarter of a cycle ahead of the mode holds its amplitude."""
    given = case(seed, 1, MODE_SLIDERS, 3.0, distance, (0.03, 0.1))
    small, law = reduced(given, forced=False)
    model = rom.tabulate(small, law, (1.5 * given.amplitude[0],), 1e-3)
    curve = rom.backbone(model, amplitude=given.amplitude[0] * np.geomspace(0.1, 1.3, 12))
    shape = given.system.M @ small.mode_shapes[:, 0]
    for r, Omega, zeta in zip(curve.amplitude, curve.frequency, curve.damping, strict=True):
        _, X, *_ = balance(given.system, Omega, 4j * zeta * Omega**2 * r * shape)
        assert abs(0.5 * shape @ X / r - 1.0) < 2e-4
