"""Modes that are marched with elastic contacts: their damping is in no answer."""

import numpy as np
import pytest
from elastic.cantilever import LAWS, cantilever

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation
from slipmode.rom.contact.torus import marched_modes
from slipmode.rom.contact.torus.marched_modes import MarchedModes

ORDERS = [(0, 0), (1, 0), (3, 0), (-1, 2)]


def reduced_with(name, modes=(0, 1)):
    return rom.reduce(cantilever(LAWS[name]), modes, law=LAWS[name])


def test_their_response_is_that_of_damped_oscillators_to_second_order():
    reduced = reduced_with("mixed")
    modes = MarchedModes.of(reduced, 64)
    omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
    zeta = np.where(np.arange(omega.size) < 2, 1.0, 0.5)
    nu = np.array(ORDERS) @ reduced.carrier
    D = omega**2 - nu[:, None] ** 2 + 2j * zeta * omega * nu[:, None]
    exact = np.einsum("qk,kc,kd->qcd", 1.0 / D - modes.static, modes.drawn, modes.drawn)
    errors = [
        np.abs(MarchedModes.of(reduced, steps).response(reduced.carrier, ORDERS) - exact).max()
        for steps in (128, 256, 512)
    ]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.1)


def test_static_response_is_in_the_flexibility_already():
    reduced = reduced_with("mixed")
    modes = MarchedModes.of(reduced, 64)
    own = modes.drawn[:2].T / reduced.frequency**2 @ modes.drawn[:2]
    np.testing.assert_allclose(modes.response(reduced.carrier, [(0, 0)])[0], own, atol=1e-12)


@pytest.mark.parametrize("name", list(LAWS))
def test_the_answer_does_not_depend_on_their_damping(monkeypatch, name):
    amplitude = [[0.006, 0.003]]
    answers = []
    for damping in (0.2, 0.5, 2.0):
        monkeypatch.setattr(marched_modes, "_DAMPING", damping)
        reduced = reduced_with(name)  # what is marched is kept for each
        terms = (
            ContactProblem.of(reduced, LAWS[name])
            .on(Discretisation(128, 16), 1e-7)
            .solve(amplitude)
        )
        answers.append(terms.S[0])
    np.testing.assert_allclose(answers[1:], [answers[0]] * 2, rtol=2e-3)


def test_modes_far_below_the_carrier_are_not_marched():
    reduced = reduced_with("Jenkins", (2,))
    assert np.any(reduced.nonresonant_frequency < 0.7 * reduced.carrier[0])
    faster = reduced.nonresonant_frequency >= 0.7 * reduced.carrier[0]
    assert len(MarchedModes.of(reduced, 64).drawn) == 1 + np.count_nonzero(faster)
