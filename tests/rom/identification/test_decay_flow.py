"""Slow flow and its sensor signals against a general integrator and closed forms."""

import numpy as np
import pytest
from measured.decays import TRUE, coupled_amplitudes, power_law_amplitude, times

from slipmode.rom import Record, SlowLaw
from slipmode.rom.identification.decay_flow import Decays, as_columns, integrate, sampling
from slipmode.rom.identification.slow_laws import LawForm

OWN_A = (0.4, 770.0, 0.6, 2.0, 1.2, 0.3)
OWN_B = (2.5, 1530.0, 1.2, 4.0, 1.4, 0.7)
Q_1, Q_2 = 0.1 + 0.05j, -0.6 + 0.2j
START = np.array([0.9 + 0.2j, -0.5 + 0.6j])
REFERENCE = np.array([0.8, 1.3])


def values(own_A=OWN_A, own_B=OWN_B, q_1=Q_1, q_2=Q_2):
    """The same law for reference amplitudes other than 1."""
    found = []
    for own, reference in zip((own_A, own_B), REFERENCE, strict=True):
        delta_0, omega_0, g, h, p, kappa = own
        found += [delta_0, omega_0, g * reference**p, h * reference**p, p, kappa]
    return np.array([*found, q_1.real, q_1.imag, q_2.real, q_2.imag])


LAW = SlowLaw(LawForm(2, "quadratic", True), values(), REFERENCE)


def decays_of(t, signal, rate, shapes=((1.0, 1.0),)):
    record = Record("hit", np.atleast_2d(signal), 1.0 / t[1])
    carrier = np.array([765.0, 1535.0])
    return Decays.of([record], carrier, np.array(shapes, complex), REFERENCE, rate)


def test_signals_of_coupled_modes_agree_with_a_general_integrator():
    t = times(2.5)
    expected = coupled_amplitudes(t, START, OWN_A, OWN_B, Q_1, Q_2).sum(axis=0).real
    made = decays_of(t, expected, rate=12.0)
    found = made.signals(LAW, START[:, np.newaxis])[0][0]
    assert np.abs(found - expected).max() < 1e-5  # 5e-6 with steps of 17 ms


def test_errors_of_steps_are_of_fourth_order():
    """Halved steps: 1/16 of the error."""
    t = times(1.0)
    expected = coupled_amplitudes(t, START, OWN_A, OWN_B, Q_1, Q_2).sum(axis=0).real
    errors = [
        np.abs(decays_of(t, expected, rate).signals(LAW, START[:, np.newaxis])[0][0] - expected)
        for rate in (6.0, 12.0)
    ]
    assert errors[0].max() / errors[1].max() == pytest.approx(16.0, rel=0.35)


def test_columns_and_records_are_integrated_side_by_side():
    carrier = np.array([765.0, 1535.0])
    both = np.stack([LAW.values, values(q_1=0j, q_2=0j)], axis=1)
    start = np.stack([np.stack([START, 0.3 * START], axis=1)] * 2, axis=1)
    together = integrate(both, start, REFERENCE, carrier, 0.01, 50)
    for column in range(2):
        for record in range(2):
            alone = integrate(
                both[:, [column]],
                start[:, [column]][:, :, [record]],
                REFERENCE,
                carrier,
                0.01,
                50,
            )
            assert together[:, :, :, column, record] == pytest.approx(alone[..., 0, 0], rel=1e-12)


def test_one_mode_agrees_with_the_closed_form():
    t = times(2.0)
    delta_0, omega_0, g, h, p = TRUE[0]
    law = np.array([delta_0, omega_0, g, h, p, 0.0])[:, np.newaxis]
    carrier = np.array([omega_0])
    nodes = integrate(law, np.full((1, 1, 1), 0.7 + 0.1j), np.ones(1), carrier, 0.02, 100)
    found = sampling(t, carrier, np.ones((1, 1), complex), 0.02, 100) @ as_columns(nodes, 0)[:, 0]
    expected = power_law_amplitude(t, 0.7 + 0.1j, *TRUE[0]).real
    assert np.abs(found - expected).max() < 1e-8


def test_channels_have_the_shapes_of_the_modes():
    t = times(1.0)
    z = coupled_amplitudes(t, START, OWN_A, OWN_B, Q_1, Q_2)
    shapes = np.array([[1.0, 1.0], [-0.5, 0.3 + 0.1j]])
    expected = (shapes @ z).real
    found = decays_of(t, expected, 12.0, shapes).signals(LAW, START[:, np.newaxis])[0]
    assert np.abs(found - expected).max() < 1e-5


def test_rates_of_a_law_for_arrays_of_amplitudes():
    a, b = np.meshgrid([0.1, 0.9], [0.2, 0.5, 1.0], indexing="ij")
    delta, omega = LAW.damping_rates(a, b), LAW.frequencies(a, b)
    assert delta.shape == omega.shape == (2, 2, 3)
    for own, size, other, d, w in zip((OWN_A, OWN_B), (a, b), (b, a), delta, omega, strict=True):
        power = (size**2 + own[5] * other**2) ** (own[4] / 2)
        assert d == pytest.approx(own[0] + own[2] * power)
        assert w == pytest.approx(own[1] - own[3] * power)
    assert LAW.coupling == pytest.approx([Q_1, Q_2])
