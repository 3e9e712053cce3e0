"""Models of identified laws: rates, sensor units, range, and what they leave out."""

import dataclasses
import re

import numpy as np
import pytest
from measured.decays import BANDS, OWN_A, OWN_B, TRUE, coupled_amplitudes, decays, measurement
from measured.decays import times as sampled

from slipmode import fmu, rom


@pytest.fixture(scope="module")
def two_modes():
    return rom.identify(measurement(decays(1, 4)), bands=BANDS, law="power", cross=False)


@pytest.mark.oracle
def test_a_model_has_the_true_rates_at_sensor_amplitudes(two_modes):
    mass, omega = np.array([2.0, 0.5]), TRUE[:, 1]
    model = two_modes.model(modal_mass=mass)
    sensor = np.array([[1.0, 0.2], [0.5, 0.9], [0.1, 0.4]]) * two_modes.range[:, 1]
    # A velocity of amplitude 2 omega phi |a|, phi = 1 / sqrt(modal mass).
    damping, frequency = rom.decay_rates(model, sensor / (2.0 / np.sqrt(mass) * omega))
    delta_0, omega_0, g, h, p = TRUE.T
    np.testing.assert_allclose(damping, delta_0 + g * sensor**p, rtol=0.015)
    np.testing.assert_allclose(frequency, omega_0 - h * sensor**p, atol=0.03)
    np.testing.assert_allclose(damping.T, two_modes.law.damping_rates(*sensor.T), rtol=2e-3)
    np.testing.assert_allclose(model.reduced.mode_shapes, [1.0 / np.sqrt(mass)])


@pytest.mark.oracle
def test_a_component_measures_what_the_sensor_measured(two_modes):
    """Velocities from displacements: the phase of the factors counts."""
    model = two_modes.model(modal_mass=[2.0, 0.5])
    factors = two_modes.sensor_factors(modal_mass=[2.0, 0.5])
    largest = two_modes.range[:, 1]
    quietest = min(two_modes.records, key=lambda record: max(record.amplitude / largest))
    made = two_modes.predict(quietest.name)
    moving = fmu.Component(model, contact=True, elastic=[0])
    moving.reset(amplitude=made.amplitude[0] * np.exp(1j * made.phase[0]) / factors)
    x, step = [], 1e-5
    for k in range(3):  # a difference over 20 us
        x.append(moving.outputs()["x_0"])
        moving.do_step(k * step, step)
    measured = np.interp(step, made.record.times, made.record.signal[0])
    assert (x[2] - x[0]) / (2.0 * step) == pytest.approx(measured, abs=5e-3)  # noise 1e-3


def test_samples_have_the_intervals_and_travel_with_the_model(two_modes, tmp_path):
    laws = two_modes.samples(400)
    for k, name in enumerate(two_modes.law.form.names):
        if name in two_modes.interval:
            low, high = two_modes.interval[name]
            ends = np.percentile([law.values[k] for law in laws], [2.5, 97.5])
            np.testing.assert_allclose(ends, [low, high], atol=0.12 * (high - low))
    model = two_modes.model(samples=3)
    model.save(tmp_path / "model.npz")
    loaded = rom.Model.load(tmp_path / "model.npz")
    assert loaded.hash == model.hash != two_modes.model().hash
    direct = dataclasses.replace(two_modes, law=laws[1]).model()
    moved = []
    for each in (fmu.Component(loaded, sample=2), fmu.Component(direct)):
        each.set_inputs(frequency_A=769.0, frequency_B=1529.0)
        each.reset(amplitude=0.9 * model.table.amplitude_range)
        each.do_step(0.0, 1.0)
        moved.append([complex(*list(each.outputs().values())[k : k + 2]) for k in (1, 3)])
    np.testing.assert_allclose(moved[0], moved[1], rtol=1e-3)  # of the table; measured 2e-4
    with pytest.raises(rom.SlipmodeError, match=r"sample = 4: must be 0 to 3"):
        fmu.Component(loaded, sample=4)
    with pytest.raises(rom.SlipmodeError, match=r"sample = 1: must be 0, .* has no samples"):
        fmu.Component(direct, sample=1)
    few = rom.identify(measurement(decays(1, 2)), bands=BANDS, law="power", cross=False)
    with pytest.raises(rom.SlipmodeError, match=r"samples: need a finite deviation of each"):
        few.samples(3)


@pytest.mark.parametrize(
    ("unit", "derivatives", "size"),
    [("um", 0, 1e-6), ("mm/s", 1, 1e-3), ("m/s²", 2, 1.0), ("g", 2, 9.80665)],
)
def test_the_unit_gives_quantity_and_size(unit, derivatives, size):
    found = rom.identify(measurement(decays(1, 1), unit=unit), bands=BANDS, law="linear")
    omega = found.law.frequencies(np.zeros(1), np.zeros(1))[:, 0]
    factors = found.sensor_factors(mode_shape=[-0.5, 2.0])
    np.testing.assert_allclose(factors, np.array([-1.0, 4.0]) * (1j * omega) ** derivatives / size)


def test_models_and_backbones_end_at_the_measured_range_unless_asked_for(two_modes):
    beyond = 2.0 * two_modes.range[:, 1]
    for call in (two_modes.model, two_modes.backbone):
        with pytest.raises(rom.SlipmodeError, match=r"is beyond the largest measured"):
            call(amplitude=beyond)
    factors = np.abs(two_modes.sensor_factors())
    made = two_modes.model(amplitude=beyond, extrapolate=True)
    np.testing.assert_array_equal(made.table.amplitude_range, beyond / factors)
    assert two_modes.backbone(0, amplitude=beyond, extrapolate=True).damping.size == 2


@pytest.mark.oracle
def test_quadratic_coupling_is_refused_with_its_size():
    rng, signals = np.random.default_rng(2), []
    for start in rng.uniform(0.5, 1.0, (4, 2)):
        z = coupled_amplitudes(sampled(), start, OWN_A, (*OWN_B[:5], 0.0), q_1=0.5j, q_2=-1.0)
        signals.append(z.sum(axis=0).real + 1e-3 * rng.standard_normal(sampled().size))
    found = rom.identify(measurement(signals), bands=BANDS, law="quadratic", cross=False)
    A, B = found.range[:, 1]
    shares = [0.5 * B / (0.4 + 0.6 * A**1.2), A**2 / B / (2.5 + 1.2 * B**1.4)]
    words = r"law: .* modes A and B at (\S+) and (\S+) times .* law='power' to fit a law without"
    with pytest.raises(rom.SlipmodeError, match=words) as refused:
        found.model()
    said = re.search(words, str(refused.value)).groups()
    assert [float(each) for each in said] == pytest.approx(shares, rel=0.05)
