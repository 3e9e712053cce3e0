"""Laws of decays in closed form, or integrated by others: which law is chosen, which values."""

import numpy as np
import pytest
from measured.decays import (
    BANDS,
    OWN_A,
    OWN_B,
    TRUE,
    amplitudes,
    coupled_amplitudes,
    decays,
    measurement,
    power_law_amplitude,
    times,
)
from scipy.integrate import solve_ivp

from slipmode import fmu, rom

pytestmark = pytest.mark.oracle
SLOW = [pytest.param(seed, marks=pytest.mark.slow) for seed in (1, *range(4, 36))]


def drawn(seed):
    """Kind, true values, scale, and the law of one to five records without noise, of any size."""
    rng, kind = np.random.default_rng(seed), ("linear", "coulomb", "power", "two modes")[seed % 4]
    scale = 10.0 ** rng.uniform(-6.0, 6.0)
    records, alike = int(rng.integers(1, 6)), rng.random() < 0.5
    f, zeta = rng.uniform(20.0, 300.0), 10.0 ** rng.uniform(-3.3, -2.0)
    omega, d = 2.0 * np.pi * f, 2.0 * np.pi * f * zeta
    t = np.arange(round(8.0 * f * rng.uniform(2.0, 6.0) / d)) / (8.0 * f)
    modes, bands = [[d, omega, d * rng.uniform(0.3, 2.0), d, rng.uniform(0.7, 2.0)]], [(0.8, 1.2)]
    if kind == "two modes":
        modes.append([1.3 * d, 2.7 * omega, d * rng.uniform(0.3, 2.0), d, rng.uniform(0.7, 2.0)])
        bands.append((2.3, 3.0))
    signals = []
    for k in range(records):
        size = (k + 1.0) / records if alike else rng.uniform(0.4, 1.0)
        phase = np.exp(2j * np.pi * (np.array([0.1, 0.3]) if alike else rng.random(2)))
        if kind == "linear":
            a = size * phase[0] * np.exp((1j * omega - d) * t)
        elif kind == "coulomb":  # c = 0.2 d
            falling = np.maximum((size + 0.2) * np.exp(-d * t) - 0.2, 0.0)
            a = falling * phase[0] * np.exp(1j * omega * t)
        else:
            made = zip(phase, modes, strict=False)
            a = sum(power_law_amplitude(t, size * p, *m) for p, m in made)
        signals.append(scale * a.real)
    bands = [(low * f, high * f) for low, high in bands]
    return kind, modes[0], scale, rom.identify(measurement(signals, 8.0 * f), bands=bands)


@pytest.mark.parametrize("seed", [0, 2, 3, *SLOW])
def test_a_law_without_noise_is_found(seed):
    kind, (delta_0, omega, g, h, p), scale, found = drawn(seed)
    law = "power" if kind == "two modes" else kind
    assert found.law.form.law == law and not found.deviations
    own, R = found.parameters, found.law.reference[0] / scale
    assert own["delta_0_A"] == pytest.approx(delta_0, rel=1e-3)
    assert own["omega_0_A"] == pytest.approx(omega, rel=1e-5)
    if law == "coulomb":
        assert own["g_A"] * R == pytest.approx(0.2 * delta_0, rel=2e-3)
    if law == "power":
        assert own["p_A"] == pytest.approx(p, rel=5e-3)
        assert own["g_A"] == pytest.approx(g * R**p, rel=5e-3)
        assert own["h_A"] == pytest.approx(h * R**p, rel=5e-3)


def released(t, start, omega, zeta, f):
    """Displacement after release at rest: half a cycle after half a cycle of viscous damping.

    The deceleration f of friction moves the middle of half a cycle by f / omega^2. The amplitude
    falls as da/dt = -zeta omega a - 2 f / (pi omega).
    """
    offset, omega_d = f / omega**2, omega * np.sqrt(1.0 - zeta**2)
    half, shape = np.pi / omega_d, zeta / np.sqrt(1.0 - zeta**2)
    x, begun, sign = start, 0.0, 1.0
    out = np.full(t.size, start)
    while abs(x) > offset and begun <= t[-1]:
        tau, size = t - begun, x - sign * offset
        wave = np.cos(omega_d * tau) + shape * np.sin(omega_d * tau)
        moved = sign * offset + size * np.exp(-zeta * omega * tau) * wave
        x = sign * offset - size * np.exp(-zeta * omega * half)
        begun, sign = begun + half, -sign
        out = np.where(tau >= 0.0, np.where(t < begun, moved, x), out)
    return out


def check_constant_friction(seed, noise):
    """Return the rates delta_0 and c [1/s, mm/s] of a drawn oscillator, and what is identified."""
    rng = np.random.default_rng(seed)
    frequency, zeta = rng.uniform(30.0, 80.0), 10.0 ** rng.uniform(-3.2, -2.5)
    omega = 2.0 * np.pi * frequency
    delta_0 = zeta * omega
    c = rng.uniform(0.1, 0.6) * delta_0  # of an amplitude of 1 mm
    t = np.arange(round(20.0 * frequency * rng.uniform(2.0, 4.0) / delta_0)) / (20.0 * frequency)
    signals = [
        released(t, a, omega, zeta, c * np.pi * omega / 2.0) + noise * rng.standard_normal(t.size)
        for a in rng.uniform(1.0, 3.0, 4)
    ]
    data = measurement(signals, 20.0 * frequency, "mm")
    found = rom.identify(data, bands=[(0.9 * frequency, 1.1 * frequency)])
    assert found.law.form.law == "coulomb"
    assert not found.deviations and not found.unidentified
    assert found.parameters["delta_0_A"] == pytest.approx(delta_0, rel=0.02)
    assert found.parameters["g_A"] * found.law.reference[0] == pytest.approx(c, rel=0.02)
    for a in (0.3, 1.0):
        rate = found.law.damping_rates(np.array([a]))[0, 0]
        assert rate == pytest.approx(delta_0 + c / a, rel=0.01)
    return delta_0, c, found


def test_a_constant_friction_force_is_a_law_and_its_model_decays_so():
    """a(t) = (a_0 + c / delta_0) exp(-delta_0 t) - c / delta_0, above the smallest amplitude."""
    delta_0, c, found = check_constant_friction(0, 1e-3)
    factor = abs(found.sensor_factors()[0])
    component, largest = fmu.Component(found.model()), 0.99 * found.range[0, 1]
    component.reset(amplitude=largest / factor)
    limit = np.log((largest + c / delta_0) / (1.2 * found.range[0, 0] + c / delta_0)) / delta_0
    for share in (0.3, 0.4, 0.2):
        component.do_step(component.time, share * limit)
        out = component.outputs()
        exact = (largest + c / delta_0) * np.exp(-delta_0 * component.time) - c / delta_0
        assert factor * np.hypot(out["A_re"], out["A_im"]) == pytest.approx(
            exact, abs=2e-3 * largest
        )


SMALL, WIDE = (0.1, 0.15, 0.2, 0.25, 0.3), (0.1, 0.3, 1.0, 2.0, 3.0)  # [mm]


@pytest.mark.parametrize(
    ("sizes", "unit", "noise"),
    [
        (SMALL, "mm", 1e-3),
        pytest.param(SMALL, "m", 0.0, marks=pytest.mark.slow),
        pytest.param(WIDE, "mm", 0.0, marks=pytest.mark.slow),
    ],
)
def test_decays_by_friction_may_end_at_rest(sizes, unit, noise):
    """c = 2 f / (pi omega) with f = 40 mm/s^2; found within 0.2 % in any unit, of any size."""
    t, omega, rng = np.arange(5000) / 1000.0, 2.0 * np.pi * 50.0, np.random.default_rng(0)
    mm = 1.0 if unit == "mm" else 1e-3
    noises = noise * rng.standard_normal((len(sizes), t.size))
    signals = mm * (np.array([released(t, a, omega, 1e-3, 40.0) for a in sizes]) + noises)
    found = rom.identify(measurement(signals, 1000.0, unit), bands=[(45.0, 55.0)])
    assert found.law.form.law == "coulomb" and not found.deviations
    assert [r.use for r in found.records][1:] == 4 * ["fitted"]
    c, (low, high) = mm * 80.0 / (np.pi * omega) / found.law.reference[0], found.interval["g_A"]
    assert found.parameters["g_A"] == pytest.approx(c, rel=0.03) and low < c < high


def coupled_decays(q_1=0.0, q_2=0.0, kappa=0.8, records=5):
    rng, t = np.random.default_rng(8), times()
    return [
        coupled_amplitudes(t, start, OWN_A, (*OWN_B[:5], kappa), q_1, q_2).sum(axis=0).real
        + 1e-3 * rng.standard_normal(t.size)
        for start in amplitudes(rng, records)
    ]


def test_cross_effects_are_chosen_and_found():
    found = rom.identify(measurement(coupled_decays()), bands=BANDS, law="power")
    assert found.law.form.cross
    assert found.parameters["kappa_B"] == pytest.approx(0.8, abs=0.05)
    assert found.parameters["kappa_A"] == pytest.approx(0.0, abs=0.03)


@pytest.mark.parametrize("law", ["quadratic", pytest.param("auto", marks=pytest.mark.slow)])
def test_quadratic_coupling_is_found(law):
    q = 0.1 + 0.05j, -0.6 + 0.2j
    signals = coupled_decays(*q, kappa=0.0)
    found = rom.identify(measurement(signals), bands=BANDS, law=law, cross=False)
    assert found.law.form.law == "quadratic"
    assert found.law.coupling == pytest.approx(q, abs=0.01)


@pytest.mark.slow
def test_an_oscillator_with_cubic_stiffness_and_damping():
    """x'' + 2 d x' + w^2 x + k x^3 + c x'^3 = 0: p = 2, g = 3 c v^2 / 8, h = -3 k v^2 / 8 w^3.

    Of the velocity amplitude v = w a, by averaging to first order in the nonlinear terms.
    """
    d, w, k, c, t = 0.8, 700.0, 6e8, 3.0, times(2.0)

    def slope(_, z):
        x, v = z[:4], z[4:]
        return np.append(v, -2 * d * v - w**2 * x - k * x**3 - c * v**3)

    start = [0.0, 0.0, 0.0, 0.0, 0.5, 0.7, 0.9, 1.0]
    signals = solve_ivp(slope, (0, t[-1]), start, "DOP853", t, rtol=1e-8, atol=1e-11).y[4:]
    found = rom.identify(measurement(signals), bands=[(95.0, 130.0)], law="power")
    square = found.law.reference[0] ** 2
    assert found.parameters["p_A"] == pytest.approx(2.0, abs=0.02)
    assert found.parameters["delta_0_A"] == pytest.approx(d, rel=5e-3)
    assert found.parameters["g_A"] == pytest.approx(3 * c / 8 * square, rel=0.01)
    assert found.parameters["h_A"] == pytest.approx(-3 * k / (8 * w**3) * square, rel=0.01)


def sliders(starts, omega=690.0, c=0.6, share=0.02, chi=-0.5, step=1e-4, every=5):
    """Velocities (records, samples) of a mass on springs, a damper and 30 sliders of Iwan's.

    By the leapfrog method; macro-slip is twice beyond the largest motion.
    """
    phi = np.geomspace(1e-3, 1.0, 30) * 2.0 / omega
    k = phi ** (chi + 1.0)
    k *= share * omega**2 / k.sum()
    v, x = np.array(starts), np.zeros(len(starts))
    slid, found = np.zeros((len(starts), phi.size)), []
    for i in range(round(2.5 / step)):
        slid = np.minimum(np.maximum(slid, x[:, np.newaxis] - phi), x[:, np.newaxis] + phi)
        force = (x[:, np.newaxis] - slid) @ k
        v = v - step * ((1.0 - share) * omega**2 * x + 2.0 * c * v + force)
        x = x + step * v
        if i % every == 0:
            found.append(v)
    return np.transpose(found)


def test_sliders_of_iwan_are_recognised():
    """A power law with p = chi + 1 and the shift of frequency that Masing's rule ties to it."""
    rng = np.random.default_rng(0)
    signals = sliders([0.3, 0.45, 0.6, 0.8, 1.0])
    signals += 1e-3 * rng.standard_normal(signals.shape)
    found = rom.identify(measurement(signals), bands=[(95.0, 125.0)])
    assert found.law.form.law == "iwan"
    assert found.parameters["p_A"] == pytest.approx(0.5, abs=0.01)
    assert found.parameters["delta_0_A"] == pytest.approx(0.6, rel=0.01)
    free = rom.identify(measurement(signals), bands=[(95.0, 125.0)], law="power")
    assert free.parameters["h_A"] == pytest.approx(free.law.friction_shift[0], rel=0.03)


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
    made = found.model(mode_shape=[1.4, 2.0])  # at channel 2; sensors are DOFs
    np.testing.assert_allclose(
        made.reduced.mode_shapes, shapes / shapes[2] * [1.4, 2.0], atol=4e-3
    )


def test_one_record_gives_a_law_without_intervals():
    found = rom.identify(measurement(decays(5, 1)), bands=BANDS, law="power", cross=False)
    assert found.parameters["delta_0_A"] == pytest.approx(0.4, rel=0.02)
    assert all(np.isinf(d) for d in found.deviation.values())
    assert np.isinf(found.backbone(0).damping_deviation).all()


def test_constant_rates_leave_the_exponents_open():
    linear = TRUE.copy()
    linear[:, 2:4] = 1e-9
    found = rom.identify(
        measurement(decays(3, modes=linear)), bands=BANDS, law="power", cross=False
    )
    assert {"p_A", "p_B"} <= set(found.unidentified)
    assert not {"delta_0_A", "omega_0_A", "delta_0_B", "omega_0_B"} & set(found.unidentified)
