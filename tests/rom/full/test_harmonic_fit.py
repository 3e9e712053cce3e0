"""Harmonics told apart in windows of a few periods, because it is known where they are."""

import numpy as np
import pytest

from slipmode.rom.full.harmonic_fit import HarmonicFit
from slipmode.rom.reduction.combination import harmonic_orders

CARRIER = np.array([1.0, 1.69])


def signal(time, fit, lines):
    return 2.0 * np.real(np.exp(1j * np.outer(time, fit.frequency)) @ lines)


@pytest.mark.parametrize("even", [False, True])
def test_all_lines_of_a_window_are_found(even):
    fit = HarmonicFit.over(20.0, CARRIER, harmonic_orders(7, 2, even))
    rng = np.random.default_rng(0)
    lines = rng.normal(size=(len(fit.orders), 3)) + 1j * rng.normal(size=(len(fit.orders), 3))
    lines[fit.frequency == 0.0] = lines[fit.frequency == 0.0].real
    time = fit.times(137.0)
    found = fit.lines(137.0, signal(time, fit, lines))
    assert found == pytest.approx(lines, abs=1e-10)
    assert fit.nonharmonic_share(signal(time, fit, lines)) <= 1e-12


def test_what_is_no_line_is_left():
    fit = HarmonicFit.over(20.0, CARRIER, harmonic_orders(7, 2))
    time = fit.times(0.0)
    moved = signal(time, fit, np.eye(len(fit.orders), 1)) + 5.0
    subharmonic = np.cos(0.5 * time)[:, np.newaxis]
    assert fit.nonharmonic_share(moved - 5.0 + 0.1 * subharmonic) == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize(("ratio", "periods"), [(3.0, 20.0), (3.004, 20.0), (3.004, 400.0)])
def test_lines_that_a_window_does_not_tell_apart_are_one(ratio, periods):
    fit = HarmonicFit.over(periods, np.array([1.0, ratio]), harmonic_orders(7, 2))
    told = ratio != 3.0 and periods > 1.0 / (ratio - 3.0)
    assert ((3, 0) in fit.orders) == told
    assert fit.orders[:2] == [(1, 0), (0, 1)]
    lines = np.arange(1.0, len(fit.orders) + 1.0)[:, np.newaxis].astype(complex)
    assert fit.lines(9.0, signal(fit.times(9.0), fit, lines)) == pytest.approx(lines, abs=1e-8)
