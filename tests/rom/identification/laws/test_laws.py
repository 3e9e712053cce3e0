"""Laws of synthetic decays: the right one is chosen, with the right parameters."""

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
    parameters,
    times,
)
from scipy.integrate import solve_ivp

from slipmode import rom


def coupled_decays(q_1=0.0, q_2=0.0, kappa=0.8, records=5):
    rng = np.random.default_rng(8)
    own_B = (*OWN_B[:5], kappa)
    t = times()
    return [
        coupled_amplitudes(t, start, OWN_A, own_B, q_1, q_2).sum(axis=0).real
        + 1e-3 * rng.standard_normal(t.size)
        for start in amplitudes(rng, records)
    ]


def test_one_mode():
    found = rom.identify(measurement(decays(2, modes=TRUE[:1])), bands=BANDS[:1])
    assert found.law.form == type(found.law.form)(1, "power", False)
    for name, value in parameters(found, TRUE[:1]).items():
        assert found.parameters[name] == pytest.approx(value, rel=0.01), name


@pytest.mark.slow
def test_a_linear_law_is_chosen_where_rates_are_constant():
    linear = TRUE.copy()
    linear[:, 2:4] = 1e-9
    found = rom.identify(measurement(decays(3, modes=linear)), bands=BANDS)
    assert found.law.form.law == "linear"
    assert found.parameters["delta_0_A"] == pytest.approx(0.4, rel=1e-3)


def test_cross_effects_are_chosen_and_found():
    found = rom.identify(measurement(coupled_decays()), bands=BANDS)
    assert found.law.form.cross
    assert found.parameters["kappa_B"] == pytest.approx(0.8, abs=0.05)
    assert found.parameters["kappa_A"] == pytest.approx(0.0, abs=0.03)


@pytest.mark.slow
def test_quadratic_coupling_is_chosen_and_found():
    signals = coupled_decays(0.1 + 0.05j, -0.6 + 0.2j, kappa=0.0)
    found = rom.identify(measurement(signals), bands=BANDS, cross=False)
    assert found.law.form.law == "quadratic"
    assert found.law.coupling == pytest.approx([0.1 + 0.05j, -0.6 + 0.2j], abs=0.01)


@pytest.mark.parametrize(("frequency", "tried"), [(246.0, True), (250.0, False), (275.0, False)])
def test_quadratic_coupling_is_tried_near_1_to_2_only(frequency, tried):
    """By the frequencies of the modes, whatever the bands: else fits took up to 107 s."""
    modes = TRUE.copy()
    modes[:, 1] = 2.0 * np.pi * np.array([122.0, frequency])
    signals = decays(1, 3, modes=modes, t=times(1.5))
    found = rom.identify(measurement(signals), bands=[(90.0, 160.0), (185.0, 300.0)])
    assert any(form.law == "quadratic" for form in found.errors) == tried
    steps_per_second = 1.0 / found.source.decays.step
    assert steps_per_second < 100.0  # 67, 23, 25; 975 where a beat of 31 Hz is resolved


def test_an_oscillator_with_cubic_stiffness_and_damping():
    """x'' + 2 d x' + w^2 x + k x^3 + c x'^3 = 0: p = 2, g = 3 c w^2 v^2 / 8, h = -3 k a^2 / 8 w.

    Of the velocity v = w a, to first order in the nonlinear terms.
    """
    d, w, k, c = 0.8, 700.0, -6e3, 3e-3
    t = times(2.0)

    def slope(_, z):
        x, v = z
        return [v, -2 * d * v - w**2 * x - k * x**3 * w**2 / 1e3 - c * v**3]

    signals = []
    for v in (0.5, 0.7, 0.9, 1.0):
        x = solve_ivp(slope, (0, t[-1]), [0.0, v], "DOP853", t, rtol=1e-8, atol=1e-11)
        signals.append(x.y[1])
    found = rom.identify(measurement(signals), bands=[(95.0, 130.0)], law="power")
    reference = found.law.reference[0]
    assert found.parameters["p_A"] == pytest.approx(2.0, abs=0.02)
    assert found.parameters["delta_0_A"] == pytest.approx(d, rel=5e-3)
    assert found.parameters["g_A"] == pytest.approx(3 * c / 8 * reference**2, rel=0.01)


def sliders(starts, omega=690.0, c=0.6, share=0.02, chi=-0.5, step=5e-5, every=10):
    """Velocities (records, samples) of a mass on springs, a damper and 30 sliders of Iwan's.

    By the leapfrog method; macro-slip is twice beyond the largest motion.
    """
    phi = np.geomspace(1e-3, 1.0, 30) * 2.0 / omega
    k = phi ** (chi + 1.0)
    k *= share * omega**2 / k.sum()
    v, x = np.array(starts), np.zeros(len(starts))
    slid = np.zeros((len(starts), phi.size))
    found = []
    for i in range(round(2.5 / step)):
        slid = np.clip(slid, x[:, np.newaxis] - phi, x[:, np.newaxis] + phi)
        force = (k * (x[:, np.newaxis] - slid)).sum(axis=1)
        v = v - step * ((1.0 - share) * omega**2 * x + 2.0 * c * v + force)
        x = x + step * v
        if i % every == 0:
            found.append(v)
    return np.transpose(found)


@pytest.mark.slow
def test_sliders_of_iwan_are_recognised():
    """A power law with p = chi + 1 and the shift of frequency that Masing's rule ties to it."""
    rng = np.random.default_rng(0)
    signals = sliders([0.3, 0.45, 0.6, 0.8, 1.0])
    signals += 1e-3 * rng.standard_normal(signals.shape)
    found = rom.identify(measurement(signals), bands=[(95.0, 125.0)])
    assert found.law.form.law == "iwan"
    assert found.parameters["p_A"] == pytest.approx(0.5, abs=0.01)  # 0.502
    assert found.parameters["delta_0_A"] == pytest.approx(0.6, rel=0.01)
    free = rom.identify(measurement(signals), bands=[(95.0, 125.0)], law="power")
    assert free.parameters["h_A"] == pytest.approx(free.law.friction_shift[0], rel=0.03)  # 1 %


def test_parameters_without_effect_are_named():
    """Constant rates leave the exponents open."""
    linear = TRUE.copy()
    linear[:, 2:4] = 1e-9
    data = measurement(decays(3, modes=linear))
    found = rom.identify(data, bands=BANDS, law="power", cross=False)
    assert {"p_A", "p_B"} <= set(found.unidentified)
    assert not {"delta_0_A", "omega_0_A", "delta_0_B", "omega_0_B"} & set(found.unidentified)


def test_one_record_is_enough_for_a_law():
    found = rom.identify(measurement(decays(5, 1)), bands=BANDS)
    assert found.law.form.law == "power"
    assert found.parameters["delta_0_A"] == pytest.approx(0.4, rel=0.02)
