"""Models of identified laws: rates, sensor units, range, and what they leave out."""

import re

import numpy as np
import pytest
from measured.decays import BANDS, coupled_amplitudes, decays, measurement, times

from slipmode import fmu, rom

OWN_A = (0.4, 770.0, 0.6, 2.0, 1.2, 0.0)
OWN_B = (2.5, 1530.0, 1.2, 4.0, 1.4, 0.0)


@pytest.fixture(scope="module")
def two_modes():
    return rom.identify(measurement(decays(1, 4)), bands=BANDS, law="power", cross=False)


@pytest.fixture(scope="module")
def model(two_modes):
    return two_modes.model(modal_mass=[2.0, 0.5])


def test_a_model_has_the_rates_of_the_law_at_sensor_amplitudes(two_modes, model):
    mass, rest = np.array([2.0, 0.5]), two_modes.law.frequencies(np.zeros(1), np.zeros(1))[:, 0]
    sensor = np.array([[1.0, 0.2], [0.5, 0.9], [0.1, 0.4]]) * two_modes.range[:, 1]
    a = sensor / (2.0 / np.sqrt(mass) * rest)  # of a velocity
    damping, frequency = rom.decay_rates(model, a)
    np.testing.assert_allclose(damping.T, two_modes.law.damping_rates(*sensor.T), rtol=2e-3)
    np.testing.assert_allclose(frequency.T, two_modes.law.frequencies(*sensor.T), rtol=1e-5)
    np.testing.assert_allclose(model.reduced.mode_shapes, [1.0 / np.sqrt(mass)])
    largest = two_modes.range[:, 1] / np.abs(two_modes.sensor_factors(modal_mass=mass))
    np.testing.assert_array_equal(model.table.amplitude_range, largest)


def test_a_component_measures_what_the_sensor_measured(two_modes, model):
    """Velocities from displacements: the phase of the factors counts."""
    factors = two_modes.sensor_factors(modal_mass=[2.0, 0.5])
    largest = two_modes.range[:, 1]
    quietest = min(two_modes.records, key=lambda record: max(record.amplitude / largest))
    made = two_modes.predict(quietest.name)
    a = made.amplitude[0] * np.exp(1j * made.phase[0]) / factors
    moving = fmu.Component(model, contact=True, elastic=[0])
    moving.reset(amplitude=a)
    x, step = [], 1e-5
    for k in range(3):  # a difference over 20 us
        x.append(moving.outputs()["x_0"])
        moving.do_step(k * step, step)
    velocity = (x[2] - x[0]) / (2.0 * step)
    measured = np.interp(step, made.record.times, made.signal[0])
    assert velocity == pytest.approx(measured, abs=2e-3 * made.amplitude[0].sum())


@pytest.mark.parametrize(
    ("unit", "derivatives", "size"),
    [("um", 0, 1e-6), ("mm/s", 1, 1e-3), ("m/s^2", 2, 1.0), ("m/s²", 2, 1.0), ("g", 2, 9.80665)],
)
def test_the_unit_gives_quantity_and_size(unit, derivatives, size):
    found = rom.identify(measurement(decays(1, 4), unit=unit), bands=BANDS, law="linear")
    omega = found.law.frequencies(np.zeros(1), np.zeros(1))[:, 0]
    factors = found.sensor_factors(mode_shape=[-0.5, 2.0])
    np.testing.assert_allclose(factors, np.array([-1.0, 4.0]) * (1j * omega) ** derivatives / size)


def test_a_model_ends_at_the_measured_range_unless_asked_for(two_modes):
    beyond = 2.0 * two_modes.range[:, 1]
    with pytest.raises(rom.SlipmodeError, match=r"amplitude: .* is beyond the largest measured"):
        two_modes.model(amplitude=beyond)
    factors = np.abs(two_modes.sensor_factors())
    made = two_modes.model(amplitude=beyond, extrapolate=True)
    np.testing.assert_array_equal(made.table.amplitude_range, beyond / factors)


def test_sensors_are_dofs():
    rng = np.random.default_rng(4)
    shapes = np.array([[0.2, 0.9], [1.0, -0.6], [0.7, 1.0]])
    signals = []
    for start in rng.uniform(0.5, 1.0, (4, 2)):
        z = coupled_amplitudes(times(), start, OWN_A, OWN_B)
        signals.append((shapes @ z).real + 1e-3 * rng.standard_normal((3, times().size)))
    found = rom.identify(measurement(signals), bands=BANDS, law="power", cross=False)
    made = found.model(mode_shape=[1.4, 2.0])  # at channel 2
    expected = shapes / shapes[2] * [1.4, 2.0]
    np.testing.assert_allclose(made.reduced.mode_shapes, expected, atol=4e-3)


def test_quadratic_coupling_is_refused_with_its_size():
    rng = np.random.default_rng(2)
    signals = []
    for start in rng.uniform(0.5, 1.0, (4, 2)):
        z = coupled_amplitudes(times(), start, OWN_A, OWN_B, q_1=0.5j, q_2=-1.0)
        signals.append(z.sum(axis=0).real + 1e-3 * rng.standard_normal(times().size))
    found = rom.identify(measurement(signals), bands=BANDS, law="quadratic", cross=False)
    A, B = found.range[:, 1]
    shares = [0.5 * B / (0.4 + 0.6 * A**1.2), A**2 / B / (2.5 + 1.2 * B**1.4)]
    words = (
        r"law: .* modes A and B at (\S+) and (\S+) times .* law='power' to fit a law without it$"
    )
    with pytest.raises(rom.SlipmodeError, match=words) as refused:
        found.model()
    said = re.search(words, str(refused.value)).groups()
    assert [float(each) for each in said] == pytest.approx(shares, rel=0.05)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"modal_mass": [1.0]}, "modal_mass = [1.0]: must be one number > 0 [kg] for each of the"),
        ({"modal_mass": -1.0}, "modal_mass = [-1.0, -1.0]: must be one number > 0 [kg]"),
        ({"mode_shape": [0.0, 1.0]}, "mode_shape = [0.0, 1.0]: must be one number other than 0"),
        ({"modal_mass": 1.0, "mode_shape": [1.0, 1.0]}, "modal_mass: must be left out if mode_sh"),
        ({"amplitude": [0.1]}, "amplitude = [0.1]: must be 2 finite numbers > 0 [sensor unit]"),
    ],
)
def test_wrong_arguments_are_refused(two_modes, given, words):
    with pytest.raises(rom.SlipmodeError) as refused:
        two_modes.model(**given)
    assert str(refused.value).startswith(words)


def test_a_unit_that_is_no_motion_is_refused():
    found = rom.identify(measurement(decays(1, 4), unit="V"), bands=BANDS, law="linear")
    with pytest.raises(rom.SlipmodeError, match=r"unit = 'V': must be m, m/s, m/s\^2"):
        found.model()
