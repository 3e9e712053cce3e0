"""Laws from steady sine tests of an oscillator that is solved without slipmode."""

from dataclasses import replace

import matplotlib
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


def force_controlled(*forces, phase_error=0.08):
    """Tests by time integration, at constant forces [N]."""
    tests = []
    for size in forces:
        force = np.full(FREQUENCY.size, size)
        x = TRUE.marched(FREQUENCY, force) * np.exp(-1j * phase_error)
        response = -((2.0 * np.pi * FREQUENCY) ** 2) * x
        tests.append(rom.SineTest(f"F_{size:g}", FREQUENCY, force, response))
    return rom.SineTests(tests, "m/s^2")


@pytest.fixture(scope="module")
def marched():
    return force_controlled(0.2, 0.5, 0.9, 1.4, 2.0)


@pytest.fixture(scope="module")
def found(marched):
    return rom.identify_sine(marched, band=BAND)


def test_the_law_of_force_controlled_tests_is_found(found):
    assert found.control == "force"
    assert not found.unidentified
    for name, value in parameters(found).items():  # 1.2 % in h_A
        assert found.parameters[name] == pytest.approx(value, rel=0.02), name
    assert found.frequency_scatter < 0.01
    for level in found.levels:
        assert level.phase_error == pytest.approx(0.08, abs=0.01)


def test_a_test_that_was_not_fitted_is_predicted(found):
    (made,) = found.predict(force_controlled(1.1), band=BAND)
    assert made.error < 2e-3  # 4e-4
    assert abs(made.peak_error) < 2e-3
    assert made.frequency == pytest.approx(TRUE.omega, rel=1e-4)
    (given,) = found.predict(force_controlled(1.1), band=BAND, frequency=TRUE.omega)
    assert given.frequency == TRUE.omega
    assert given.amplitude == pytest.approx(made.amplitude, rel=2e-2)


def test_a_sweep_stays_on_its_branch_of_a_fold():
    """Softening by more than the bandwidth; up and down differ between the folds."""
    soft = Oscillator(k3=-6e11)
    tests = [response_controlled(soft, a, FREQUENCY) for a in (10.0, 15.0, 20.0, 30.0, 40.0)]
    found = rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)
    frequency = np.linspace(77.5, 80.5, 121)
    force = np.full(frequency.size, 0.55)
    up = rom.SineTest("up", frequency, force, np.ones(frequency.size, complex))
    down = rom.SineTest("down", frequency[::-1], force, np.ones(frequency.size, complex))
    natural = found.law.values[1]
    made = found.predict(
        rom.SineTests([up, down], "m/s^2"), band=BAND, frequency=natural, extrapolate=True
    )
    rising, falling = made[0].amplitude, made[1].amplitude[::-1]
    differ = np.abs(falling / rising - 1.0) > 0.1
    assert 3 < np.count_nonzero(differ) < 60
    assert (falling[differ] > rising[differ]).all()
    for amplitude in (rising, falling):
        omega = 2.0 * np.pi * frequency
        x = amplitude / omega**2
        assert np.abs(soft.stiffness(omega, x) * x) == pytest.approx(force, rel=0.03)  # 1.9 %


def test_without_the_phase_error_damping_is_biased():
    frequency = np.linspace(79.5, 82.5, 31)  # mostly above the resonance
    tests = [response_controlled(Oscillator(), a, frequency, 0.15) for a in (10.0, 30.0, 50.0)]
    found = rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=(79.0, 83.0), law="linear")
    for level in found.levels:
        assert level.damping == pytest.approx(0.004, rel=1e-4)
        assert level.left_out_damping == pytest.approx(0.004, rel=1e-4)
        assert level.damping_without_phase < 0.6 * level.damping
        assert level.phase_error == pytest.approx(0.15, abs=1e-4)


@pytest.mark.slow
def test_intervals_contain_the_truth():
    """Levels that scatter by 1.5 % in damping and mass, 0.075 Hz in frequency; 0.5 % noise."""
    sets, inside = 40, {}
    for seed in range(sets):
        data = response_controlled_set(
            np.random.default_rng(seed), (10, 25, 40, 55, 70, 85), scatter=0.015, noise=0.005
        )
        found = rom.identify_sine(data, band=(78.0, 82.0))
        true = parameters(found, Oscillator(m=1.8, zeta=0.002, c3=1.5e8))
        for name, (low, high) in found.interval.items():
            inside[name] = inside.get(name, 0) + (low <= true[name] <= high)
    assert min(inside.values()) >= 0.85 * sets  # of 100 sets 92 to 98 %


def test_backbones_have_bands_and_points(found):
    line = found.backbone()
    assert line.steady
    assert line.amplitude[[0, -1]] == pytest.approx(found.range[0])
    x = line.amplitude / line.frequency**2
    damping = TRUE.stiffness(TRUE.omega, x).imag / (2.0 * TRUE.m * TRUE.omega**2)
    assert line.damping == pytest.approx(damping, rel=5e-3)
    assert set(line.points) == {level.name for level in found.levels}
    assert (line.damping_deviation < 0.01 * line.damping).all()
    matplotlib.use("Agg")
    assert line.plot()[1].get_xlabel() == "amplitude of mode A [m/s^2]"
    with pytest.raises(rom.SlipmodeError, match=r"amplitude: 200 is beyond the largest measured"):
        found.backbone(amplitude=200.0)
    assert found.backbone(amplitude=200.0, extrapolate=True).damping.size == 1
    with pytest.raises(rom.SlipmodeError, match="amplitude: must be finite numbers > 0"):
        found.backbone(amplitude=[-1.0])


def test_steady_states_of_the_model_are_those_of_time_integration(found):
    model = found.model()
    frequency = np.array([79.0, 79.6, 79.8, 80.0, 80.3, 81.0])
    a = rom.steady(model, 2.0 * np.pi * frequency[:, np.newaxis], [{0: 1.5}])
    x = 2.0 * np.abs(model.reduced.mode_shapes[0, 0] * a[:, 0])
    marched = np.abs(TRUE.marched(frequency, np.full(frequency.size, 1.5)))
    assert x == pytest.approx(marched, rel=5e-3)


def test_a_linear_law_needs_two_levels():
    tests = [response_controlled(Oscillator(), a, FREQUENCY) for a in (10.0, 30.0)]
    found = rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND, law="linear")
    assert found.parameters["delta_0_A"] == pytest.approx(0.004 * TRUE.omega, rel=1e-3)
    assert set(found.parameters) == {"delta_0_A", "omega_0_A", "modal_mass"}


@pytest.mark.parametrize(("unit", "order"), [("m", 0), ("m/s", 1), ("m/s^2", 2)])
def test_all_units_give_the_same_mass(unit, order):
    omega = 2.0 * np.pi * FREQUENCY
    tests = [
        rom.SineTest(
            f"x_{x:g}",
            FREQUENCY,
            TRUE.stiffness(omega, x) * x,
            x * (1j * omega) ** order,
        )
        for x in np.array([1.0, 1.5, 2.0, 3.0]) * 1e-4
    ]
    found = rom.identify_sine(rom.SineTests(tests, unit), band=BAND)
    assert found.parameters["modal_mass"] == pytest.approx(TRUE.m, rel=1e-3)
    assert found.parameters["delta_0_A"] == pytest.approx(0.004 * TRUE.omega, rel=1e-2)
    (made,) = found.predict(rom.SineTests(tests[2:3], unit), band=BAND)
    assert made.error < 5e-3


def controlled(a, frequency=FREQUENCY, oscillator=TRUE):
    return response_controlled(oscillator, a, frequency)


def noise(test):
    rng = np.random.default_rng(1)
    wave = rng.standard_normal((2, test.frequency.size)).T @ [1, 1j]
    return rom.SineTest(f"noise {test.name}", test.frequency, test.force, wave)


def two_modes(test):
    other = Oscillator(m=2.5, frequency=78.0, zeta=0.004)
    omega = 2.0 * np.pi * FREQUENCY
    receptance = 1.0 / TRUE.stiffness(omega, 0.0) + 1.0 / other.stiffness(omega, 0.0)
    return rom.SineTest(
        f"two {test.name}", FREQUENCY, test.force, -(omega**2) * receptance * test.force
    )


def changed(test, **fields):
    values = {
        "name": "x",
        "frequency": test.frequency,
        "force": test.force,
        "response": test.response,
    }
    return rom.SineTest(**(values | fields))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: changed(t, response=np.abs(t.response)), "x has a response without phase"),
        (lambda t: changed(t, force=t.force[1:]), "x must have frequency, force and response of"),
        (lambda t: changed(t, force=0.0 * t.force), "force of x must be finite and not 0"),
        (lambda t: changed(t, response=np.nan * t.response), "response of x must be finite"),
        (lambda t: changed(t, response=t.force / t.force.conj()), "no resonance|negative damping"),
        (lambda t: changed(t, response=1j * t.response), r"x has a phase error of -?1\.\d+ rad"),
        (noise, "noise a_10 has no resonance of one mode between 77.5 and 82 Hz"),
        (two_modes, "two a_[0-9]+ has no resonance of one mode"),
        (
            lambda t: controlled(10.0, np.linspace(60.0, 70.0, 41)),
            "must have at least 4 points between 77 and",
        ),
        (lambda t: controlled(10.0, np.linspace(80.9, 83.0, 41)), "a_10 has no resonance of one"),
        (lambda t: controlled(10.0, np.arange(77.0, 83.0, 0.5)), r"a_10 has \d points within the"),
        (
            lambda t: changed(t, force=t.force.conj(), response=t.response.conj()),
            "x has negative damping: the phase of response / force must fall",
        ),
    ],
)
def test_unsound_tests_are_refused(change, message):
    tests = [controlled(a) for a in (10.0, 30.0, 50.0, 70.0)]
    tests = [
        change(tests[0]),
        *(map(change, tests[1:]) if change in (noise, two_modes) else tests[1:]),
    ]
    with pytest.raises(rom.SlipmodeError, match=f"tests: .*({message})"):
        rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"band": (83.0, 77.0)}, "band = (83.0, 77.0): must be 0 < lower < upper end"),
        ({"band": 80.0}, "band = 80.0: must be 0 < lower < upper end"),
        ({"law": "cubic"}, "law = 'cubic': must be power or linear"),
        ({"unit": "g"}, "unit = 'g': must be m, m/s, m/s^2"),
        ({"levels": 3}, "tests: must have at least 4 levels for a power law, got 3"),
    ],
)
def test_wrong_arguments_are_refused(arguments, message):
    given = {"band": BAND, "unit": "m/s^2", "levels": 4} | arguments
    tests = [controlled(a) for a in (10.0, 30.0, 50.0, 70.0)][: given.pop("levels")]
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.identify_sine(rom.SineTests(tests, given.pop("unit")), **given)
    assert message in str(refusal.value)


def test_levels_of_both_kinds_are_refused(marched):
    tests = [*marched.tests[:3], controlled(30.0), controlled(50.0)]
    with pytest.raises(
        rom.SlipmodeError, match=r"F_0.9 are force-controlled, a_30, a_50 response"
    ):
        rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)


def test_predictions_beyond_the_measured_amplitudes_are_refused_unless_asked_for(found):
    loud = rom.SineTests([controlled(200.0)], "m/s^2")
    with pytest.raises(rom.SlipmodeError, match=r"amplitude: .* is beyond the largest measured"):
        found.predict(loud, band=BAND)
    assert found.predict(loud, band=BAND, extrapolate=True)[0].error < 0.2
    with pytest.raises(rom.SlipmodeError, match=r"tests: must be in m/s\^2 like .*, got m/s"):
        found.predict(rom.SineTests(loud.tests, "m/s"), band=BAND)
    with pytest.raises(rom.SlipmodeError, match=r"frequency = -1\.0: must be > 0"):
        found.predict(loud, band=BAND, frequency=-1.0)
    with pytest.raises(rom.SlipmodeError, match="tests: names a_200 occur more than once"):
        found.predict(rom.SineTests(loud.tests * 2, "m/s^2"), band=BAND)


def test_the_deviation_of_each_level_from_the_law_is_stated():
    """One level of five was measured with a mode that has 20 % more damping at rest."""
    levels = {
        10.0: TRUE,
        25.0: TRUE,
        40.0: replace(TRUE, zeta=1.2 * TRUE.zeta),
        55.0: TRUE,
        70.0: TRUE,
    }
    tests = [response_controlled(each, a, FREQUENCY, 0.0) for a, each in levels.items()]
    found = rom.identify_sine(rom.SineTests(tests, "m/s^2"), band=BAND)
    x = np.array(list(levels)) / TRUE.omega**2
    true = [each.zeta * each.omega for each in levels.values()] + TRUE.c3 * x**2 / (8 * TRUE.m)
    expected = true / found.law.damping_rates(np.array(list(levels)))[0] - 1.0
    assert np.argmax(np.abs(found.misfit)) == 2
    np.testing.assert_allclose(found.misfit, expected, atol=0.01)
