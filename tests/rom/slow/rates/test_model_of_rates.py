"""Models of given damping and frequency, against the law itself: closed forms and scipy."""

import numpy as np
import pytest
from beside_oracle import amplitudes, run
from rates.saved_models import DROP, GROWTH, NATURAL, RANGE, REST, TWO_SHAPES
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from slipmode import fmu, rom

SHAPE = 1.2


def power_law(exponent):
    def rates(amplitudes):
        share = (amplitudes / RANGE) ** exponent
        return REST + GROWTH * share, NATURAL - DROP * share

    return rates


def two_modes(amplitudes):
    """Rates of two modes that see each other, in proportion to the measured ones of a beam."""
    a, b = np.asarray(amplitudes).T
    s_A, s_B = np.sqrt(a**2 + 0.2 * b**2) / RANGE, np.sqrt(b**2 + 0.8 * a**2) / RANGE
    damping = np.stack((1.5 + 2.0 * s_A**1.1, 2.2 + 3.0 * s_B), axis=-1)
    frequency = np.stack((122.0 - 1.0 * s_A**1.1, 243.0 - 1.4 * s_B), axis=-1)
    return damping, 2.0 * np.pi * frequency


@pytest.fixture(scope="module", params=[1, 2])
def law(request):
    return request.param, rom.model_of_rates(
        power_law(request.param), (RANGE,), mode_shapes=[[SHAPE], [0.5]]
    )


@pytest.fixture(scope="module")
def pair():
    return rom.model_of_rates(two_modes, (RANGE, RANGE), mode_shapes=TWO_SHAPES)


def ring_down(model, start, carriers, times):
    """Complex amplitudes of the component at times, in the frame of the carriers."""
    given = {f"frequency_{m}": Omega for m, Omega in zip("AB", carriers, strict=False)}
    return amplitudes(run(model, None, times[1:], start=start, **given))


# One mode


@pytest.mark.oracle
@pytest.mark.quick
def test_backbone_and_rates_are_the_law(law):
    exponent, model = law
    amplitude = np.geomspace(1e-3, 0.998, 300) * RANGE
    damping, frequency = power_law(exponent)(amplitude)
    curve = rom.backbone(model, amplitude=amplitude)
    # S_j of the norm: 2 omega |a| times the change of the rates and the damping
    stated = model.accuracy.total * (np.hypot(damping, frequency - NATURAL) + REST)
    found = rom.decay_rates(model, amplitude[:, np.newaxis])
    assert np.all(np.abs(found[0][:, 0] - damping) <= stated)
    assert np.all(np.abs(found[1][:, 0] - frequency) <= stated)
    steady = np.sqrt(frequency**2 - damping**2 + 2.0 * REST * damping)  # no decay
    assert np.all(np.abs(curve.frequency - steady) <= stated)
    assert np.all(np.abs(curve.decay - damping) <= stated)
    np.testing.assert_allclose(curve.damping, damping / frequency, rtol=1e-3)
    # measured 6.0e-5 and 3.5e-7
    np.testing.assert_allclose(found[0][:, 0], damping, rtol=1e-4)
    np.testing.assert_allclose(found[1][:, 0], frequency, rtol=1e-6)


@pytest.mark.oracle
@pytest.mark.quick
def test_free_vibration_has_its_closed_form(law):
    """r' = -d r - g r^(p + 1), phase' = w - h r^p in the frame of the carrier."""
    p, model = law
    times, start = np.linspace(0.0, 2.0, 401), 0.95 * RANGE
    g, t = GROWTH / RANGE**p, times[1:]
    a = ring_down(model, [start], [0.995 * NATURAL], times)[:, 0]
    decay = np.exp(-p * REST * t)
    modulus = start * (decay / (1.0 + g / REST * start**p * (1.0 - decay))) ** (1.0 / p)
    integral = np.log1p(g / REST * start**p * (1.0 - decay)) / (p * g)  # of r^p
    phase = 0.005 * NATURAL * t - DROP / RANGE**p * integral
    turned = np.unwrap(np.angle(a * np.exp(-1j * phase)))
    np.testing.assert_allclose(np.abs(a), modulus, rtol=5e-5)  # measured 1.9e-5
    assert np.abs(turned).max() <= 2e-4  # [rad], measured 6.0e-5


@pytest.mark.oracle
@pytest.mark.quick
@pytest.mark.parametrize("force", [0.9, 8.0])
def test_steady_states_and_curves_have_their_closed_form(law, force):
    """|(w_0^2 - Omega^2 + i gamma Omega) - Q| r = F / 2, Q = (s + d_0)^2 + w_d^2, written out."""
    exponent, model = law
    Omega = np.linspace(0.985, 1.005, 41) * NATURAL
    modal = SHAPE * force

    def deficit(r, Omega):
        share = (r / RANGE) ** exponent
        s = -(REST + GROWTH * share) + 1j * (NATURAL - DROP * share)
        Q = (s + REST) ** 2 + NATURAL**2
        D = REST**2 + NATURAL**2 - Omega**2 + 2j * REST * Omega
        return r * abs(D - Q) - 0.5 * modal

    amplitude = rom.steady(model, Omega[:, np.newaxis], [{0: force}])
    exact = [brentq(deficit, 1e-12, RANGE, args=(each,)) for each in Omega]
    np.testing.assert_allclose(np.abs(amplitude[:, 0]), exact, rtol=1e-6)  # measured 8.8e-8
    ends = (0.985 * NATURAL,), (1.005 * NATURAL,)
    curve = rom.response_curve(model, [NATURAL], [{0: force}], "frequency", ends)
    at = 0.985 * NATURAL + curve.parameter * 0.02 * NATURAL
    off = [
        abs(r - brentq(deficit, 1e-12, RANGE, args=(each,)))
        for r, each in zip(np.abs(curve.amplitude[:, 0]), at, strict=True)
    ]
    assert np.all(off <= curve.error[:, 0] + 1e-9 * RANGE)


@pytest.mark.oracle
def test_damping_that_rises_from_below_zero_ends_in_its_limit_cycle():
    def rates(amplitudes):
        return -1.0 + 2.0 * amplitudes / RANGE, NATURAL - DROP * amplitudes / RANGE

    model = rom.model_of_rates(rates, (RANGE,))
    (cycle,) = rom.limit_cycles(model)
    assert abs(cycle.amplitude[0]) == pytest.approx(0.5 * RANGE, rel=1e-3)
    assert cycle.frequency[0] == pytest.approx(NATURAL - 0.5 * DROP, rel=1e-5)


# Two modes


@pytest.mark.oracle
@pytest.mark.quick
def test_two_modes_decay_together_as_the_law_says(pair):
    carriers = 2.0 * np.pi * np.array([121.0, 242.0])
    start, times = np.array([0.7, 0.9 * np.exp(1j)]) * RANGE, np.linspace(0.0, 1.5, 151)

    def growth(_, y):
        a = y.view(complex)
        damping, frequency = two_modes(np.abs(a))
        return ((-damping + 1j * (frequency - carriers)) * a).view(float)

    solved = solve_ivp(
        growth, (0.0, 1.5), start.view(float), t_eval=times[1:], rtol=1e-10, atol=1e-14
    )
    exact = np.ascontiguousarray(solved.y.T).view(complex)
    a = ring_down(pair, start, carriers, times)
    np.testing.assert_allclose(np.abs(a), np.abs(exact), rtol=5e-5)  # measured 1.2e-5
    assert np.abs(np.angle(a / exact)).max() <= 2e-4  # [rad], measured 3.3e-5


@pytest.mark.oracle
@pytest.mark.quick
def test_rates_of_two_modes_are_the_law_within_the_stated_error(pair):
    points = np.random.default_rng(5).uniform(0.0, 0.998, (2000, 2)) * RANGE
    exact = two_modes(points)
    s = -exact[0] + 1j * exact[1]
    damping, frequency = rom.decay_rates(pair, points.reshape(40, 50, 2))
    assert damping.shape == frequency.shape == (40, 50, 2)
    off = np.abs(-damping + 1j * frequency - s.reshape(40, 50, 2))
    error = 2.0 * pair.reduced.frequency * points.reshape(40, 50, 2) * off
    assert np.all(error <= pair.friction_error(points.reshape(40, 50, 2)))
    np.testing.assert_allclose(damping.reshape(-1, 2), exact[0], rtol=1e-3)  # measured 3.5e-4


# Any model


@pytest.mark.oracle
def test_a_large_change_of_the_frequency_is_stated():
    """The slow flow is of first order: the error falls with the square of the change."""

    def rates(change):
        return lambda a: (REST + 0.0 * a, NATURAL * (1.0 - change * a / RANGE))

    errors = []
    for change in (0.02, 0.04):
        model = rom.model_of_rates(rates(change), (RANGE,), 1e-6, warned=False)
        points = np.linspace(0.1, 0.99, 50)[:, np.newaxis] * RANGE
        damping, _ = rom.decay_rates(model, points)
        errors.append(np.abs(damping - REST).max() / REST)
    assert errors[1] / errors[0] == pytest.approx(4.0, rel=0.1)
    with pytest.warns(rom.ValidityWarning, match="rates change strongly with the amplitude: "):
        rom.model_of_rates(rates(0.04), (RANGE,), 1e-6)


# Refusals


LAW = power_law(1)


@pytest.mark.parametrize(
    ("rates", "options", "message"),
    [
        (lambda a: (a * np.nan, a + 700.0), {}, "^rates: .* nan 1/s and 700 rad/s"),
        (lambda a: (a + 1.0, 700.0 - 4e5 * a), {}, "^rates: .* 1/s and "),
        (lambda a: (np.ones(len(a)), a + 700.0), {}, "damping must have the shape"),
        (LAW, {"mode_shapes": [[1.0, 2.0]]}, r"^mode_shapes: must be \(n, 1\)"),
    ],
)
def test_wrong_rates_and_arguments_are_refused_in_one_line(rates, options, message):
    with pytest.raises(rom.SlipmodeError, match=message) as refusal:
        rom.model_of_rates(rates, **({"amplitude": (RANGE,)} | options))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda of: rom.decay_rates(of, [[3e-3]]), "at the contacts, outside"),
        (lambda of: fmu.Component(of).set_inputs(limit_scale=2.0), "the model has no contacts"),
        (lambda of: rom.performance_curve(of, 0, {0: 1.0}), "law: "),
        (lambda of: rom.steady_state(of.reduced, of.law, [NATURAL], [{0: 1.0}]), "law: "),
    ],
)
def test_what_such_a_model_does_not_have_is_refused(law, call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(law[1])
