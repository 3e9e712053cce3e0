"""Nine decays of a double beam and sine tests of a Brake-Reuss beam, measured by others.

And four decays of a panel with friction and geometric nonlinearity, by finite elements.

See shared/data/published/README.md.
"""

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from slipmode import rom

PUBLISHED = Path(__file__).parents[4] / "shared" / "data" / "published"
DECAYS = PUBLISHED / "double_beam_decays_measured.npz"
PANEL = PUBLISHED / "ssmlearn_trc_xData3DOFs.mat"
ORBITS = PUBLISHED / "ssmlearn_trc_comsolPOs.mat"
SINE = PUBLISHED / "brb_forced_responses_measured.mat"
BANDS, BAND = [(100.0, 140.0), (225.0, 260.0)], (78.0, 82.0)
pytestmark = [
    pytest.mark.oracle,
    pytest.mark.skipif(not SINE.exists(), reason="needs published/ of the shared data"),
]


@pytest.fixture(scope="module")
def data():
    return rom.read_measurement(DECAYS, quantity="velocity", unit="m/s")


@pytest.fixture(scope="module")
def beam(data):
    return rom.identify(data, bands=BANDS)


@pytest.mark.slow
def test_damping_of_the_double_beam_is_that_of_other_fits(beam):
    """zeta of mode A from 0.05 % with A^1.10 (+- 0.16). Mode B is coupled to it: not claimed."""
    assert [r.use for r in beam.records] == ["fitted"] * 9
    errors = {str(form): error for form, error in beam.errors.items()}
    assert errors["linear"] > 5.0 * errors["power"]  # 12.0 and 2.0 %
    assert beam.parameters["p_A"] == pytest.approx(1.1, abs=0.16)
    zeta = beam.parameters["delta_0_A"] / beam.parameters["omega_0_A"]
    assert zeta == pytest.approx(5e-4, rel=0.15)
    assert [line[:15] for line in beam.deviations] == ["rates of mode B"]
    assert {"g_B", "h_B", "p_B"} <= set(beam.unidentified)
    # After 1.2 s mode B is at 0.5 % of its largest amplitude, and no longer decays.
    assert beam.range[1, 0] == pytest.approx(0.01 * beam.range[1, 1])


@pytest.mark.slow
def test_one_mode_of_the_double_beam_alone(data):
    """The same damping by another fit of the envelopes: 0.05 % and A^1.10 (+- 0.16)."""
    alone = rom.identify(data, bands=BANDS[:1], law="power")
    assert alone.parameters["p_A"] == pytest.approx(1.1, abs=0.16)
    zeta = alone.parameters["delta_0_A"] / alone.parameters["omega_0_A"]
    assert zeta == pytest.approx(5e-4, rel=0.15)


@pytest.mark.slow
def test_records_that_were_left_out_are_predicted(data):
    """With the law chosen without them; the data's authors reach 3.65 %."""
    errors = []
    for record in data:
        found = rom.identify(data, bands=BANDS, hold_out=[record.name])
        errors.append(found.predict(record, extrapolate=True).error)
    assert np.mean(errors) < 0.0365


@pytest.fixture(scope="module")
def tests():
    return rom.read_sine_tests(SINE)


@pytest.fixture(scope="module")
def found(tests):
    return rom.identify_sine(tests["Response"], band=BAND)


def test_the_law_of_the_brake_reuss_beam_is_that_of_another_fit(tests, found):
    """zeta = 0.1395 % + 0.1626 % (a / 40 m/s^2)^1.60, mass 2.01 kg."""
    assert [test.control for test in tests] == ["force"] * 4 + ["response"] * 8
    a = np.array([5.0, 20.0, 40.0, 80.0])
    zeta = 1.395e-3 + 1.626e-3 * (a / 40.0) ** 1.6
    assert found.backbone(amplitude=a).damping == pytest.approx(zeta, rel=0.01)
    assert found.parameters["p_A"] == pytest.approx(1.60, abs=0.04)
    assert found.parameters["modal_mass"] == pytest.approx(2.01, abs=0.01)
    assert found.unidentified == ("h_A",)  # no trend of the frequency
    for level in found.levels:
        assert level.left_out_damping == pytest.approx(level.damping, rel=0.03)


def test_force_controlled_responses_are_predicted_by_response_controlled_ones(tests, found):
    for made in found.predict(tests["Force"], band=BAND):
        assert made.error < 0.07  # 3.9 to 6.8 % rms of the peak
        inside = np.abs(made.amplitude - np.abs(made.test.response)) < 2.0 * made.deviation
        assert inside.mean() > 0.9
    other = rom.identify_sine(tests["Force"], band=BAND)
    assert np.isinf(other.deviation["h_A"])  # four levels are too few for a shift
    for name in ("delta_0_A", "modal_mass"):
        low, high = other.interval[name]
        assert low < found.parameters[name] < high


def test_levels_that_were_left_out_are_predicted_within_their_bands(tests):
    responses, inside = tests["Response"].tests, []
    for k in range(0, 8, 2):
        others = rom.SineTests([*responses[:k], *responses[k + 1 :]], tests.unit)
        alone = rom.SineTests([responses[k]], tests.unit)
        (made,) = rom.identify_sine(others, band=BAND).predict(alone, band=BAND, extrapolate=True)
        measured = np.abs(made.test.response)
        inside.append(np.mean(np.abs(made.amplitude - measured) < 2.0 * made.deviation))
    assert np.mean(inside) > 0.9


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_decays_of_a_panel_predict_another_one_and_the_peaks_of_responses():
    """From 0.09 s on, without harmonics of the modes; `identify` excludes record 1."""
    signals = scipy.io.loadmat(PANEL)["xData3DOFs"][:, 1]
    records = [rom.Record(str(i), signal, 1e4) for i, signal in enumerate(signals)]
    data = rom.Measurement(records, "displacement", "m", ("1", "2", "3"))
    bands = [(90.0, 125.0), (180.0, 205.0)]
    found = rom.identify(data, bands=bands, law="power", hold_out=["3"])
    assert found.predict("3").error < 0.04  # 3.4 %
    assert 1.5 < found.parameters["p_A"] < 2.0  # 1.7: a^2 by the arch, and friction
    # where the first decay moves as much as the largest responses to forces
    decay, x = found.predict("0"), np.abs(signals[0][2])
    start = next(record.start for record in found.records if record.name == "0")
    for frequency, size in scipy.io.loadmat(ORBITS)["comsolPOs"]:
        k = int(size.argmax())
        last = np.flatnonzero(x > 1e-3 * size[0, k])[-1] * 1e-4 - start
        a = np.interp(last, decay.times, decay.amplitude[:, 0])
        omega = found.law.frequencies(np.array(a), np.array(0.0))[0]
        assert omega / (2.0 * np.pi) == pytest.approx(frequency[0, k], rel=0.005)  # 0.4, 0.03 %
