"""Laws from steady sine tests of an oscillator that is solved without slipmode."""

from dataclasses import replace

import numpy as np
import pytest
from measured.sine_tests import Oscillator, response_controlled, response_controlled_set

from slipmode import rom

BAND = (77.0, 83.0)
TRUE = Oscillator(c3=1.5e8, k3=-2e10)
FREQUENCY = np.linspace(77.5, 82.0, 46)


def parameters(found, oscillator=TRUE):
    """True parameters for the reference amplitude of an identification."""
    x = found.law.reference[0] / found.law.frequencies(found.law.reference)[0, 0] ** 2
    g = 1 / 8 * oscillator.c3 * x**2 / oscillator.m
    h = -3 / 8 * oscillator.k3 * x**2 / (oscillator.m * oscillator.omega)
    values = (oscillator.zeta * oscillator.omega, oscillator.omega, g, h, 2.0, oscillator.m)
    names = ("delta_0_A", "omega_0_A", "g_A", "h_A", "p_A", "modal_mass")
    return dict(zip(names, values, strict=True))


def controlled(*amplitudes, oscillator=TRUE, frequency=FREQUENCY, phase_error=0.0):
    tests = [response_controlled(oscillator, a, frequency, phase_error) for a in amplitudes]
    return rom.SineTests(tests, "m/s^2")


@pytest.fixture(scope="module")
def marched():
    """Tests at constant forces [N] by time integration, with a phase error of 0.08 rad."""
    frequency = np.linspace(78.4, 81.2, 29)
    forces = np.array([0.2, 0.5, 0.9, 1.4, 2.0, 1.1])
    both = np.meshgrid(frequency, forces)
    x = TRUE.marched(*(each.ravel() for each in both)).reshape(6, -1) * np.exp(-0.08j)
    omega = 2.0 * np.pi * frequency
    tests = [
        rom.SineTest(f"F_{size:g}", frequency, np.full(frequency.size, size), -(omega**2) * row)
        for size, row in zip(forces, x, strict=True)
    ]
    return rom.SineTests(tests[:5], "m/s^2"), rom.SineTests(tests[5:], "m/s^2")


@pytest.fixture(scope="module")
def found(marched):
    return rom.identify_sine(marched[0], band=BAND)


@pytest.mark.oracle
def test_the_law_of_force_controlled_tests_is_found(found):
    assert found.control == "force"
    assert not found.unidentified
    for name, value in parameters(found).items():
        assert found.parameters[name] == pytest.approx(value, rel=0.02), name
    assert found.frequency_scatter < 0.01
    for level in found.levels:
        assert level.phase_error == pytest.approx(0.08, abs=0.01)
    line = found.backbone()
    assert line.steady and line.amplitude[[0, -1]] == pytest.approx(found.range[0])
    x = line.amplitude / line.frequency**2
    damping = TRUE.stiffness(TRUE.omega, x).imag / (2.0 * TRUE.m * TRUE.omega**2)
    assert line.damping == pytest.approx(damping, rel=5e-3)
    assert (line.damping_deviation < 0.01 * line.damping).all()
    assert line.plot()[1].get_xlabel() == "amplitude of mode A [m/s^2]"


@pytest.mark.oracle
def test_a_test_that_was_not_fitted_is_predicted(found, marched):
    (made,) = found.predict(marched[1], band=BAND)
    assert made.error < 2e-3 and abs(made.peak_error) < 2e-3
    assert made.frequency == pytest.approx(TRUE.omega, rel=1e-4)
    (given,) = found.predict(marched[1], band=BAND, frequency=TRUE.omega)
    assert given.amplitude == pytest.approx(made.amplitude, rel=2e-2)


@pytest.mark.oracle
def test_steady_states_of_the_model_are_those_of_time_integration(found, marched):
    model, (test,) = found.model(), marched[1].tests
    a = rom.steady(model, 2.0 * np.pi * test.frequency[::5, np.newaxis], [{0: 1.1}])
    x = 2.0 * np.abs(model.reduced.mode_shapes[0, 0] * a[:, 0])
    expected = np.abs(test.response[::5]) / (2.0 * np.pi * test.frequency[::5]) ** 2
    assert x == pytest.approx(expected, rel=5e-3)


@pytest.mark.oracle
def test_a_sweep_stays_on_its_branch_of_a_fold():
    """Softening by more than the bandwidth; up and down differ between the folds."""
    soft = Oscillator(k3=-6e11)
    found = rom.identify_sine(controlled(10.0, 15.0, 20.0, 30.0, 40.0, oscillator=soft), band=BAND)
    frequency = np.linspace(77.5, 80.5, 121)
    force, any_response = np.full(frequency.size, 0.55), np.ones(frequency.size, complex)
    up = rom.SineTest("up", frequency, force, any_response)
    down = rom.SineTest("down", frequency[::-1], force, any_response)
    made = found.predict(
        rom.SineTests([up, down], "m/s^2"),
        band=BAND,
        frequency=found.law.values[1],
        extrapolate=True,
    )
    rising, falling = made[0].amplitude, made[1].amplitude[::-1]
    differ = np.abs(falling / rising - 1.0) > 0.1
    assert 3 < np.count_nonzero(differ) < 60
    assert (falling[differ] > rising[differ]).all()
    for amplitude in (rising, falling):
        omega = 2.0 * np.pi * frequency
        x = amplitude / omega**2
        assert np.abs(soft.stiffness(omega, x) * x) == pytest.approx(force, rel=0.03)


@pytest.mark.oracle
def test_without_the_phase_error_damping_is_biased():
    frequency = np.linspace(79.5, 82.5, 31)  # mostly above the resonance
    tests = controlled(
        10.0, 30.0, 50.0, oscillator=Oscillator(), frequency=frequency, phase_error=0.15
    )
    found = rom.identify_sine(tests, band=(79.0, 83.0), law="linear")
    assert set(found.parameters) == {"delta_0_A", "omega_0_A", "modal_mass"}
    for level in found.levels:
        assert level.damping == pytest.approx(0.004, rel=1e-4)
        assert level.left_out_damping == pytest.approx(0.004, rel=1e-4)
        assert level.damping_without_phase < 0.6 * level.damping
        assert level.phase_error == pytest.approx(0.15, abs=1e-4)


def hits(sets):
    """How often intervals contain the truth: scatter of 1.5 % in damping and mass, 0.5 % noise."""
    inside = {}
    for seed in range(sets):
        data = response_controlled_set(
            np.random.default_rng(seed), (10, 25, 40, 55, 70, 85), scatter=0.015, noise=0.005
        )
        found = rom.identify_sine(data, band=(78.0, 82.0))
        true = parameters(found, Oscillator(m=1.8, zeta=0.002, c3=1.5e8))
        for name, (low, high) in found.interval.items():
            inside[name] = inside.get(name, 0) + (low <= true[name] <= high)
    return np.array(list(inside.values())) / sets


@pytest.mark.slow
@pytest.mark.oracle
def test_intervals_contain_the_truth():
    assert hits(8).mean() >= 0.9


@pytest.mark.oracle
@pytest.mark.parametrize(("unit", "order"), [("m", 0), ("m/s", 1), ("m/s^2", 2)])
def test_all_units_give_the_same_mass(unit, order):
    omega = 2.0 * np.pi * FREQUENCY
    tests = []
    for x in np.array([1.0, 1.5, 2.0, 3.0]) * 1e-4:
        force, response = TRUE.stiffness(omega, x) * x, x * (1j * omega) ** order
        tests.append(rom.SineTest(f"x_{x:g}", FREQUENCY, force, response))
    found = rom.identify_sine(rom.SineTests(tests, unit), band=BAND)
    assert found.parameters["modal_mass"] == pytest.approx(TRUE.m, rel=1e-3)
    assert found.parameters["delta_0_A"] == pytest.approx(0.004 * TRUE.omega, rel=1e-2)
    for level in found.levels:  # with the polarity of the channels
        assert level.modal_mass == pytest.approx(TRUE.m, rel=1e-3)
    (made,) = found.predict(rom.SineTests(tests[2:3], unit), band=BAND)
    assert made.error < 5e-3


@pytest.mark.oracle
def test_the_deviation_of_each_level_from_the_law_is_stated():
    """One level of five was measured with a mode that has 20 % more damping at rest."""
    other = replace(TRUE, zeta=1.2 * TRUE.zeta)
    levels = {10.0: TRUE, 25.0: TRUE, 40.0: other, 55.0: TRUE, 70.0: TRUE}
    tests = [response_controlled(each, a, FREQUENCY, 0.0) for a, each in levels.items()]
    found = rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)
    x = np.array(list(levels)) / TRUE.omega**2
    true = [each.zeta * each.omega for each in levels.values()] + TRUE.c3 * x**2 / (8 * TRUE.m)
    expected = true / found.law.damping_rates(np.array(list(levels)))[0] - 1.0
    assert np.argmax(np.abs(found.misfit)) == 2
    np.testing.assert_allclose(found.misfit, expected, atol=0.01)


OMEGA = 2.0 * np.pi * FREQUENCY
OTHER = Oscillator(m=2.5, frequency=78.0, zeta=0.004)
BOTH = -(OMEGA**2) * (1.0 / TRUE.stiffness(OMEGA, 0.0) + 1.0 / OTHER.stiffness(OMEGA, 0.0))
NOISE = np.random.default_rng(1).standard_normal((2, OMEGA.size)).T @ [1, 1j]
UNSOUND = [  # a response to the force of a test
    (lambda test: np.abs(test.response), "x0 has a response without phase"),
    (lambda test: 1j * test.response, r"x0 has a phase error of -?1\.\d+ rad"),
    (lambda test: test.force * (test.response / test.force).conj(), "x0 has negative damping"),
    (lambda _: NOISE, r"x\d has no resonance of one mode between 77.5 and 82 Hz"),
    (lambda test: BOTH * test.force, r"x\d has no resonance of one mode"),
]


@pytest.mark.parametrize(("response", "message"), UNSOUND)
def test_unsound_tests_are_refused(response, message):
    tests = [
        rom.SineTest(f"x{k}", FREQUENCY, test.force, response(test))
        for k, test in enumerate(controlled(10.0, 30.0, 50.0, 70.0))
    ]
    with pytest.raises(rom.SlipmodeError, match=f"tests: .*({message})"):
        rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)


def test_levels_of_both_kinds_are_refused(marched):
    tests = [*marched[0].tests[:3], *controlled(30.0, 50.0)]
    with pytest.raises(rom.SlipmodeError, match=r"F_0.9 are force-controlled, a_30, a_50 respon"):
        rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)
