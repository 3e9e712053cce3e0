"""Laws from sine sweeps and stepped sines, as time signals of a mass with Iwan's sliders."""

import re

import numpy as np
import pytest
from measured.sweeps import (
    MASS,
    OMEGA,
    RATE,
    ZETA,
    damping,
    joint,
    steps,
    sweep,
)

from slipmode import rom

BAND = (78.2, 81.2)
DELTA = ZETA * OMEGA  # at small amplitudes: 1.51 1/s
LIMIT = 0.3 * DELTA**2 / (2.0 * np.pi)  # of a sweep: 0.11 Hz/s
FORCES = (0.05, 0.15, 0.4, 0.8)  # [N]


def demodulated(signals, noise=5e-3):
    """Sine tests with noise of 0.5 % of the largest sample."""
    rng, made = np.random.default_rng(0), []
    for k, pair in enumerate(signals, 1):
        pair = [y + noise * np.abs(y).max() * rng.standard_normal(y.size) for y in pair]
        made.append(rom.demodulate_sine_test(f"level {k}", *pair, RATE))
    return rom.SineTests(made, "m/s")


def errors_of_damping(found, law=None):
    """Relative errors of the levels, against the loss of the sliders in steady vibration."""
    return np.array([
        level.damping / damping(level.amplitude / level.frequency, law or joint()) - 1.0
        for level in found.levels
    ])  # fmt: skip


@pytest.mark.oracle
@pytest.mark.parametrize("ends", [(78.0, 81.4), (81.4, 78.0)])
def test_sweeps_at_constant_force(ends):
    data = demodulated(sweep(*ends, 0.8 * LIMIT, force) for force in FORCES)
    found = rom.identify_sine(data, band=BAND)
    assert found.control == "force"
    assert np.abs(errors_of_damping(found)).max() < 0.03
    assert found.parameters["modal_mass"] == pytest.approx(MASS, rel=0.01)
    assert found.backbone().damping[-1] > 1.4 * found.backbone().damping[0]


@pytest.mark.oracle
def test_stepped_sines():
    frequency = np.linspace(78.5, 80.9, 21)
    data = demodulated(steps(frequency, 2.4, force) for force in FORCES)
    for test in data:
        assert test.stepped
        assert test.frequency == pytest.approx(frequency, abs=0.01)
    found = rom.identify_sine(data, band=BAND)
    assert np.abs(errors_of_damping(found)).max() < 0.03


@pytest.mark.oracle
def test_sweeps_up_to_the_limit_have_the_damping_of_steady_tests():
    linear = joint(share=1e-6)
    slow, fast = (
        demodulated((sweep(78.0, 82.0, rate * LIMIT, force, linear) for force in (1, 2)), 0.0)
        for rate in (1.1, 1.5)
    )
    for band in ((78.2, 81.8), (79.5, 80.5)):
        found = rom.identify_sine(slow, band=band, law="linear")
        assert np.abs(errors_of_damping(found, linear)).max() < 0.01
        with pytest.raises(rom.SlipmodeError, match="level 1 changes too fast"):
            rom.identify_sine(fast, band=band, law="linear")


@pytest.mark.oracle
def test_fast_sweeps_and_short_steps_are_refused_with_their_limit():
    frequency = np.linspace(78.5, 80.9, 21)
    for made, words, limit in (
        ((sweep(78.0, 81.4, 3.0 * LIMIT, f) for f in FORCES), "sweep by at most (.*) Hz/s", LIMIT),
        ((steps(frequency, 1.0, f) for f in FORCES), "use steps of at least (.*) s", 4.6 / DELTA),
    ):
        with pytest.raises(rom.SlipmodeError) as refused:
            rom.identify_sine(demodulated(made), band=BAND)
        (said,) = re.findall(f"changes too fast. .* 1/s; {words}$", str(refused.value))
        assert float(said) == pytest.approx(limit, rel=0.35)  # 0.14 Hz/s, 3.0 s
    with pytest.raises(rom.SlipmodeError, match=r"no resonance .*, or sweep more slowly"):
        rom.identify_sine(demodulated(sweep(78.0, 81.4, 6.0, f) for f in FORCES), band=BAND)


def test_parts_without_drive_are_left_out():
    signals = sweep(78.0, 81.4, 0.5, 0.4)
    silence = 1e-3 * np.random.default_rng(1).standard_normal((2, 2000))
    whole = rom.demodulate_sine_test("a", *signals, RATE)
    padded = [np.concatenate([n, y, n]) for n, y in zip(silence, signals, strict=True)]
    made = rom.demodulate_sine_test("b", *padded, RATE)
    assert made.frequency.size == pytest.approx(whole.frequency.size, abs=2)
    assert made.frequency.min() == pytest.approx(78.0, abs=0.2)
    assert np.abs(made.force) == pytest.approx(0.4, rel=0.02)
