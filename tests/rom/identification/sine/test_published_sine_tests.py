"""Sine tests of a Brake-Reuss beam, measured by others (see shared/data/published/README.md)."""

from pathlib import Path

import numpy as np
import pytest

from slipmode import rom

PUBLISHED = Path(__file__).parents[5] / "shared" / "data" / "published"
FILE = PUBLISHED / "brb_forced_responses_measured.mat"
BAND = (78.0, 82.0)
pytestmark = pytest.mark.skipif(not FILE.exists(), reason="needs published/ of the shared data")


@pytest.fixture(scope="module")
def tests():
    return rom.read_sine_tests(FILE)


@pytest.fixture(scope="module")
def found(tests):
    return rom.identify_sine(tests["Response"], band=BAND)


def test_the_law_is_that_of_another_fit(tests, found):
    """zeta = 0.1395 % + 0.1626 % (a / 40 m/s^2)^1.60, mass 2.01 kg."""
    assert [test.control for test in tests] == ["force"] * 4 + ["response"] * 8
    for a in (5.0, 20.0, 40.0, 80.0):
        zeta = 1.395e-3 + 1.626e-3 * (a / 40.0) ** 1.6
        assert found.backbone(amplitude=a).damping == pytest.approx(zeta, rel=0.01)
    assert found.parameters["p_A"] == pytest.approx(1.60, abs=0.04)
    assert found.parameters["modal_mass"] == pytest.approx(2.01, abs=0.01)
    assert found.frequency_scatter / (2.0 * np.pi) == pytest.approx(0.14, abs=0.01)
    assert found.unidentified == ("h_A",)  # no trend of the frequency


def test_damping_of_a_level_is_predicted_by_the_others(found):
    for level in found.levels:
        assert level.left_out_damping == pytest.approx(level.damping, rel=0.03)  # 2.1 %
        assert 0.02 < level.phase_error < 0.17
    bias = [level.damping_without_phase / level.damping - 1.0 for level in found.levels]
    assert 0.1 < max(bias) < 0.2


def test_force_controlled_responses_are_predicted(tests, found):
    for made in found.predict(tests["Force"], band=BAND):
        assert made.error < 0.07  # 3.9 to 6.8 % rms of the peak
        assert abs(made.peak_error) < 0.04  # 3.5 %
        inside = np.abs(made.amplitude - np.abs(made.test.response)) < 2.0 * made.deviation
        assert inside.mean() > 0.9


def test_levels_that_were_left_out_are_predicted_within_their_bands(tests):
    responses, inside = tests["Response"].tests, []
    for k in range(8):
        others = rom.SineTests([*responses[:k], *responses[k + 1 :]], tests.unit)
        found = rom.identify_sine(others, band=BAND)
        (made,) = found.predict(
            rom.SineTests([responses[k]], tests.unit), band=BAND, extrapolate=True
        )
        assert made.error < 0.07  # 1.1 to 6.3 %
        measured = np.abs(made.test.response)
        inside.append(np.mean(np.abs(made.amplitude - measured) < 2.0 * made.deviation))
    assert np.mean(inside) > 0.9


def test_kinds_of_tests_differ_in_damping(tests, found):
    other = rom.identify_sine(tests["Force"], band=BAND)
    a = np.array([20.0, 40.0, 60.0, 69.0])
    difference = other.backbone(amplitude=a).damping / found.backbone(amplitude=a).damping - 1.0
    assert other.unidentified == ("h_A",)
    assert np.isinf(other.deviation["h_A"])  # four levels are too few for a shift
    assert 0.05 < np.abs(difference).max() < 0.15
    for name in ("delta_0_A", "modal_mass"):
        low, high = other.interval[name]
        assert low < found.parameters[name] < high
