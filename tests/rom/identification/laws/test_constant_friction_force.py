"""Decays of an oscillator with viscous damping and a constant friction force, in closed form.

With the friction deceleration f and the damping ratio zeta, half a cycle is a damped oscillation
about -+ f / omega^2. The amplitude falls as da/dt = -zeta omega a - 2 f / (pi omega).
"""

import numpy as np
import pytest
from measured.decays import measurement

from slipmode import rom


def decay(t, start, omega, zeta, f):
    """Displacement after release at rest, half a cycle after half a cycle."""
    offset, omega_d = f / omega**2, omega * np.sqrt(1.0 - zeta**2)
    half, shape = np.pi / omega_d, zeta / np.sqrt(1.0 - zeta**2)
    x, begun, sign = start, 0.0, 1.0
    out = np.full(t.size, start)
    while abs(x) > offset and begun <= t[-1]:
        tau, part = t - begun, t >= begun
        wave = np.cos(omega_d * tau) + shape * np.sin(omega_d * tau)
        size = x - sign * offset
        moved = sign * offset + size * np.exp(-zeta * omega * tau) * wave
        x = sign * offset - size * np.exp(-zeta * omega * half)
        begun, sign = begun + half, -sign
        out = np.where(part, np.where(t < begun, moved, x), out)
    return out


def drawn(seed, noise):
    """Rates delta_0 and c [1/s, mm/s], and what is identified; displacements in mm."""
    rng = np.random.default_rng(seed)
    frequency, zeta = rng.uniform(30.0, 80.0), 10.0 ** rng.uniform(-3.2, -2.5)
    omega = 2.0 * np.pi * frequency
    delta_0 = zeta * omega
    c = rng.uniform(0.1, 0.6) * delta_0  # of an amplitude of 1 mm
    t = np.arange(round(20.0 * frequency * rng.uniform(2.0, 4.0) / delta_0)) / (20.0 * frequency)
    signals = [
        decay(t, a, omega, zeta, c * np.pi * omega / 2.0) + noise * rng.standard_normal(t.size)
        for a in rng.uniform(1.0, 3.0, 4)
    ]
    data = measurement(signals, 20.0 * frequency, "mm")
    found = rom.identify(data, bands=[(0.9 * frequency, 1.1 * frequency)])
    return delta_0, c, found


def check(seed, noise):
    delta_0, c, found = drawn(seed, noise)
    assert found.law.form.law == "coulomb"
    assert not found.deviations and not found.unidentified
    assert found.parameters["delta_0_A"] == pytest.approx(delta_0, rel=0.02)
    assert found.parameters["g_A"] * found.law.reference[0] == pytest.approx(c, rel=0.02)
    for a in (0.3, 1.0):
        rate = found.law.damping_rates(np.array([a]))[0, 0]
        assert rate == pytest.approx(delta_0 + c / a, rel=0.01)


@pytest.mark.parametrize("seed", range(2))
def test_a_constant_friction_force_is_a_law(seed):
    check(seed, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 20))
def test_a_constant_friction_force_is_a_law_of_many_decays(seed):
    check(seed, 10.0 ** -(2 + seed % 3))


def test_a_model_has_the_friction_force_above_the_smallest_amplitude():
    """Its free decay by a component: a(t) = (a_0 + c / delta_0) exp(-delta_0 t) - c / delta_0."""
    from slipmode import fmu

    delta_0, c, found = drawn(0, 1e-3)
    model = found.model()
    factor = abs(found.sensor_factors()[0])
    component = fmu.Component(model)
    largest = 0.99 * found.range[0, 1]
    component.reset(amplitude=largest / factor)
    limit = np.log((largest + c / delta_0) / (1.2 * found.range[0, 0] + c / delta_0)) / delta_0
    for share in (0.3, 0.4, 0.2):
        component.do_step(component.time, share * limit)
        out = component.outputs()
        size = factor * np.hypot(out["A_re"], out["A_im"])
        exact = (largest + c / delta_0) * np.exp(-delta_0 * component.time) - c / delta_0
        assert size == pytest.approx(exact, abs=2e-3 * largest)
