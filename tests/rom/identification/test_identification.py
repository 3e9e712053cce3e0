"""Results of an identification: parameters, backbones, predictions, and what is refused."""

import matplotlib
import numpy as np
import pytest
from measured.decays import (
    BANDS,
    OWN_A,
    OWN_B,
    RATE,
    TRUE,
    amplitudes,
    coupled_amplitudes,
    decay,
    decays,
    measurement,
    parameters,
    times,
)

from slipmode import rom


@pytest.fixture(scope="module")
def two_modes():
    return rom.identify(measurement(decays(1)), bands=BANDS, hold_out=[2])


def test_the_power_law_of_two_modes_is_chosen_and_found(two_modes):
    assert str(two_modes.law.form) == "power"
    assert not two_modes.unidentified
    for name, value in parameters(two_modes).items():
        found = two_modes.parameters[name]
        assert found == pytest.approx(value, rel=1e-4 if "omega" in name else 0.015), name
    errors = {str(form): error for form, error in two_modes.errors.items()}
    assert errors["linear"] > 10.0 * errors["power"]


def test_held_out_records_are_predicted_from_their_first_window(two_modes):
    report = two_modes.records[1]
    assert report.use == "held out"
    assert [r.use for r in two_modes.records].count("fitted") == 5
    found = two_modes.predict(2, extrapolate=True)
    assert found.error == report.error < 5e-3  # noise of 0.1 % gives 0.2 %
    assert found.window == pytest.approx(2.25 / (770.0 / 2 / np.pi), rel=0.02)
    record = two_modes.predict(rom.Record("again", found.record.signal, RATE), extrapolate=True)
    assert record.error == pytest.approx(found.error, rel=1e-4)


def test_the_error_is_that_of_its_definition(two_modes):
    found = two_modes.predict(1)
    y, predicted = found.record.signal[0], found.signal[0]
    n = round(found.window * RATE)
    windows = range(len(y) - n + 1)
    difference = [np.linalg.norm((y - predicted)[k : k + n]) for k in windows]
    largest = max(np.linalg.norm(y[k : k + n]) for k in windows)
    assert found.error == pytest.approx(np.mean(difference) / largest)


def test_backbones_have_bands_and_points(two_modes):
    for mode in (0, 1):
        found = two_modes.backbone(mode)
        low, high = two_modes.range[mode]
        assert found.amplitude[[0, -1]] == pytest.approx([low, high])
        own = TRUE[mode]
        delta = own[0] + own[2] * found.amplitude ** own[4]
        omega = own[1] - own[3] * found.amplitude ** own[4]
        assert np.abs(found.damping * found.frequency / delta - 1.0).max() < 0.01
        assert np.abs(found.frequency - omega).max() < 0.02
        # 99 % of Student's distribution for five records
        inside = np.abs(found.damping - delta / omega) < 4.6 * found.damping_deviation
        assert inside.mean() > 0.9
        assert set(found.points) == {r.name for r in two_modes.records if r.use == "fitted"}
        for look in found.points.values():
            at = np.interp(look.amplitude, found.amplitude, found.damping * found.frequency)
            assert np.median(np.abs(look.delta / at - 1.0)) < 0.03


def test_beyond_the_measured_amplitudes_predictions_are_refused_unless_asked_for(two_modes):
    beyond = 2.0 * two_modes.range[0, 1]
    with pytest.raises(rom.SlipmodeError, match=r"amplitude: .* is beyond the largest measured"):
        two_modes.backbone(0, amplitude=[beyond])
    assert two_modes.backbone(0, amplitude=[beyond], extrapolate=True).damping.size == 1
    loud = rom.Record("loud", decay(np.random.default_rng(1), start=(1.5, 0.5))[np.newaxis], RATE)
    with pytest.raises(rom.SlipmodeError, match=r"record: loud: mode A starts at 1\.\d+ times"):
        two_modes.predict(loud)
    assert two_modes.predict(loud, extrapolate=True).error < 0.02


def test_several_channels_share_one_law():
    rng = np.random.default_rng(4)
    shapes = np.array([[0.2, 0.9], [1.0, -0.6], [0.7, 1.0]])
    t, signals = times(), []
    for start in amplitudes(rng, 4):
        z = coupled_amplitudes(t, start, OWN_A, (*OWN_B[:5], 0.0))
        signals.append((shapes @ z).real + 1e-3 * rng.standard_normal((3, t.size)))
    found = rom.identify(measurement(signals), bands=BANDS, law="power", cross=False)
    assert found.channel == "channel 2"  # which sees both modes
    assert found.shapes == pytest.approx(shapes / shapes[2], abs=2e-3)
    assert found.parameters["delta_0_A"] == pytest.approx(0.4, rel=0.01)
    assert found.parameters["p_B"] == pytest.approx(1.4, rel=0.02)


def test_intervals_of_two_records_are_infinite_and_say_so():
    found = rom.identify(measurement(decays(5, 2)), bands=BANDS, law="power", cross=False)
    assert all(np.isinf(d) for d in found.deviation.values())
    assert not found.unidentified
    assert np.isinf(found.backbone(0).damping_deviation).all()


def test_plots_have_axes_for_each_mode(two_modes):
    matplotlib.use("Agg")
    axes = two_modes.plot()
    assert axes.shape == (2, 2)
    assert axes[0, 0].get_ylabel() == "frequency [Hz]"
    assert axes[1, 1].get_xlabel() == "amplitude of mode B [m/s]"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"law": "cubic"}, "law = 'cubic': must be auto, linear, coulomb, iwan, power, quadratic"),
        ({"cross": "yes"}, "cross = 'yes': must be 'auto', True or False"),
        ({"law": "linear", "cross": True}, "cross: a linear law"),
        ({"bands": BANDS[:1], "cross": True}, "bands: cross effects"),
        ({"bands": BANDS[:1], "law": "quadratic"}, "bands: cross effects"),
        ({"hold_out": ["hit9"]}, "record 'hit9' is not in the measurement"),
        ({"hold_out": [9]}, "record 9 is not in the measurement"),
    ],
)
def test_wrong_arguments_are_refused(arguments, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.identify(measurement(decays(1, 2)), **({"bands": BANDS} | arguments))
    assert message in str(refusal.value)


def test_wrong_arguments_of_results_are_refused(two_modes):
    with pytest.raises(rom.SlipmodeError, match="mode = 2: must be 0 to 1"):
        two_modes.backbone(2)
    with pytest.raises(rom.SlipmodeError, match=r"mode = \[0.1, 0.2\]: must be 0 to 1"):
        two_modes.backbone([0.1, 0.2])
    with pytest.raises(rom.SlipmodeError, match="amplitude: must be finite numbers > 0"):
        two_modes.backbone(0, amplitude=[-1.0])
    with pytest.raises(rom.SlipmodeError, match="record 'hit9' is not in the measurement"):
        two_modes.predict("hit9")
    with pytest.raises(rom.SlipmodeError, match="record: has 2 channels, must have 1 like"):
        two_modes.predict(rom.Record("x", np.zeros((2, 5000)), RATE))
    with pytest.raises(
        rom.SlipmodeError, match="record: x cannot be used: the signal is constant"
    ):
        two_modes.predict(rom.Record("x", np.zeros((1, 5000)), RATE))
