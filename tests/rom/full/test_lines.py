"""Harmonics of a motion from a few periods, and lines beside them."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.full.harmonic_fit import HarmonicFit
from slipmode.rom.full.window import Window
from slipmode.rom.reduction.combination import harmonic_orders

FREQUENCY = np.array([1.0, 2.83])


def sampled(time, fit, lines):
    return 2.0 * np.real(np.exp(1j * np.outer(time, fit.frequency)) @ lines)


@pytest.mark.oracle
@pytest.mark.parametrize("even", [False, True])
def test_all_lines_of_a_window_are_found_and_the_rest_is_measured(even):
    fit = HarmonicFit.over(20.0, np.array([1.0, 1.69]), harmonic_orders(7, 2, even))
    rng = np.random.default_rng(0)
    lines = rng.normal(size=(len(fit.orders), 3)) + 1j * rng.normal(size=(len(fit.orders), 3))
    lines[fit.frequency == 0.0] = lines[fit.frequency == 0.0].real
    signal = sampled(fit.times(137.0), fit, lines)
    assert fit.lines(137.0, signal) == pytest.approx(lines, abs=1e-10)
    assert fit.nonharmonic_share(signal) <= 1e-12
    first = np.eye(len(fit.orders), 1) * (np.array(fit.orders)[:, :1] == [1])
    first[fit.orders.index((1, 0))] = 1.0
    beside = 0.1 * np.cos(0.5 * fit.times(0.0))[:, np.newaxis]
    share = fit.nonharmonic_share(sampled(fit.times(0.0), fit, first) + beside)
    assert share == pytest.approx(0.05, rel=0.1)


@pytest.mark.oracle
@pytest.mark.parametrize(("line", "share"), [(0.5, 0.05), (1.37, 0.02), (None, 0.0)])
def test_lines_beside_the_harmonics_are_found_and_harmonics_projected_out(line, share):
    structure = rom.two_mass()
    excitation = full.Excitation.harmonic(structure, ({0: 1.0}, {1: 1.0}), FREQUENCY)
    window = Window.of_lines(excitation)
    t = window.times(3.0)
    signal = 5.0 + 2.0 * np.real((0.2 - 0.4j) * np.exp(2.83j * t))
    signal += np.cos(t) + 0.3 * np.sin(3.0 * t + 1.0) + 0.2 * np.cos((4.0 - 2.83) * t)
    found = window.project(t, signal[:, np.newaxis], np.array([0.0, 2.83]))
    assert found[:, 0] == pytest.approx([2.5, 0.2 - 0.4j], abs=1e-9)
    if line is not None:
        signal += share * (np.std(signal) * np.sqrt(2.0)) * np.cos(line * t)
    rest = window.nonharmonic(np.column_stack((signal, 2.0 * signal)))
    assert rest.share == pytest.approx(share, rel=0.02, abs=1e-4)
    if line is not None:
        assert rest.frequency == pytest.approx(line, abs=0.01)
