"""Sine sweeps and stepped sines as time signals of an oscillator with a joint, in full order."""

import re

import numpy as np
import pytest
from measured.sweeps import RATE, JointedOscillator, controlled_sweep, steps, sweep

from slipmode import rom

BAND = (78.2, 81.2)
TRUE = JointedOscillator()
DELTA = TRUE.zeta * TRUE.omega  # at small amplitudes: 1.51 1/s
LIMIT = 0.3 * DELTA**2 / (2.0 * np.pi)  # of a sweep: 0.11 Hz/s
FORCES = (0.05, 0.15, 0.4, 0.8)  # [N]


def demodulated(drives, oscillator=TRUE, noise=5e-3):
    """Sine tests of excitations with durations; noise of 0.5 % of the largest sample."""
    rng = np.random.default_rng(0)
    made = []
    for k, (excitation, duration) in enumerate(drives, 1):
        signals = oscillator.signals(excitation, duration, rng, noise)
        made.append(rom.demodulate_sine_test(f"level {k}", *signals, RATE))
    return rom.SineTests(made, "m/s")


def errors_of_damping(found, oscillator=TRUE):
    """Relative errors of the levels, against the loss of the sliders in steady vibration."""
    for level in found.levels:
        displacement = level.amplitude / level.frequency
        yield level.damping / oscillator.damping(np.array(displacement)) - 1.0


@pytest.mark.parametrize("ends", [(78.0, 81.4), (81.4, 78.0)])
def test_sweeps_at_constant_force(ends):
    data = demodulated(sweep(*ends, 0.8 * LIMIT, force) for force in FORCES)
    found = rom.identify_sine(data, band=BAND)
    assert found.control == "force"
    assert np.abs(list(errors_of_damping(found))).max() < 0.03  # 0.5 %
    assert found.parameters["modal_mass"] == pytest.approx(TRUE.mass, rel=0.01)
    assert found.backbone().damping[-1] > 1.4 * found.backbone().damping[0]


def test_sweeps_at_constant_response():
    drives = [controlled_sweep(TRUE, 78.0, 81.4, 0.2, x) for x in (1e-5, 3e-5, 6e-5, 1e-4)]
    found = rom.identify_sine(demodulated(drives), band=BAND)
    assert found.control == "response"
    assert np.abs(list(errors_of_damping(found))).max() < 0.03  # 2.0 %
    assert found.parameters["modal_mass"] == pytest.approx(TRUE.mass, rel=0.01)


def test_stepped_sines():
    frequency = np.linspace(78.5, 80.9, 21)
    data = demodulated(steps(frequency, 2.4, force) for force in FORCES)
    for test in data:
        assert test.stepped
        assert test.frequency == pytest.approx(frequency, abs=0.01)
    found = rom.identify_sine(data, band=BAND)
    assert np.abs(list(errors_of_damping(found))).max() < 0.03  # 0.7 %


def test_sweeps_up_to_the_limit_have_the_damping_of_steady_tests():
    linear = JointedOscillator(share=1e-6)
    slow, fast = (
        demodulated((sweep(78.0, 82.0, rate * LIMIT, force) for force in (1, 2)), linear, 0.0)
        for rate in (1.1, 1.5)
    )
    for band in ((78.2, 81.8), (79.5, 80.5)):
        found = rom.identify_sine(slow, band=band, law="linear")
        # 0.1 and -0.3 %
        assert np.abs(list(errors_of_damping(found, linear))).max() < 0.01
        with pytest.raises(rom.SlipmodeError, match="level 1 changes too fast"):
            rom.identify_sine(fast, band=band, law="linear")


def test_fast_sweeps_and_short_steps_are_refused_with_their_limit():
    for drives, words, limit in (
        ([sweep(78.0, 81.4, 3.0 * LIMIT, f) for f in FORCES], "sweep by at most (.*) Hz/s", LIMIT),
        (
            [steps(np.linspace(78.5, 80.9, 21), 1.0, f) for f in FORCES],
            "use steps of at least (.*) s",
            4.6 / DELTA,
        ),
    ):
        with pytest.raises(rom.SlipmodeError) as refused:
            rom.identify_sine(demodulated(drives), band=BAND)
        (said,) = re.findall(f"changes too fast. .* 1/s; {words}$", str(refused.value))
        assert float(said) == pytest.approx(limit, rel=0.35)  # 0.14 Hz/s, 3.0 s
    hasty = demodulated([steps(np.linspace(78.5, 80.9, 41), 0.12, f) for f in FORCES])
    with pytest.raises(rom.SlipmodeError, match="level 1 changes too fast"):
        rom.identify_sine(hasty, band=BAND)
    with pytest.raises(rom.SlipmodeError, match=r"no resonance .*, or sweep more slowly"):
        rom.identify_sine(demodulated([sweep(78.0, 81.4, 6.0, f) for f in FORCES]), band=BAND)


def test_parts_without_drive_are_left_out():
    excitation, duration = sweep(78.0, 81.4, 0.5, 0.4)
    force, response = TRUE.signals(excitation, duration)
    rng = np.random.default_rng(1)
    silence = 1e-3 * rng.standard_normal((2, 2000))
    whole = rom.demodulate_sine_test("a", force, response, RATE)
    padded = [
        np.concatenate([noise, signal, noise])
        for noise, signal in zip(silence, (force, response), strict=True)
    ]
    made = rom.demodulate_sine_test("b", *padded, RATE)
    assert made.frequency.size == pytest.approx(whole.frequency.size, abs=2)
    assert made.frequency.min() == pytest.approx(78.0, abs=0.2)
    assert np.abs(made.force) == pytest.approx(0.4, rel=0.02)


T = np.arange(4000) / RATE
WAVE = np.sin(2.0 * np.pi * 80.0 * T)
FAST = np.sin(2.0 * np.pi * 90.0 * np.arange(1000) / 200.0)
NOISE = np.random.default_rng(2).standard_normal(T.size)


def test_one_frequency_is_too_few_points():
    alone = rom.SineTests([rom.demodulate_sine_test("a", WAVE, WAVE, RATE)], "m/s")
    with pytest.raises(
        rom.SlipmodeError, match=r"tests: a must have at least 4 points between 78.2 and 81.2"
    ):
        rom.identify_sine(alone, band=BAND)


@pytest.mark.parametrize(
    ("force", "response", "rate", "words"),
    [
        (WAVE, WAVE[1:], RATE, r"a must have force and response of one length, got shapes \(4000"),
        (0.0 * WAVE, WAVE, RATE, "force of a must be finite and not constant"),
        (WAVE, np.where(T > 1.0, np.nan, WAVE), RATE, "response of a must be finite and not con"),
        (
            WAVE[:200],
            WAVE[:200],
            RATE,
            "a is too short. It is driven for 200 samples and must be ",
        ),
        (
            NOISE,
            NOISE,
            RATE,
            r"a is not a sine test. \S+ % of the power of the \w+ is at one freq",
        ),
        (WAVE, WAVE, -1.0, "sample_rate = -1.0: must be > 0"),
        (FAST, FAST, 200.0, "a has drive frequencies up to 90 Hz, which needs a"),
    ],
)
def test_unsound_signals_are_refused(force, response, rate, words):
    with pytest.raises(rom.SlipmodeError, match=words) as refused:
        rom.demodulate_sine_test("a", force, response, rate)
    assert "\n" not in str(refused.value)
