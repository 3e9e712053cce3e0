"""Broken records are named, and excluded or used in part; sound ones have no notes."""

import numpy as np
import pytest
from measured.decays import (
    BANDS,
    RATE,
    TRUE,
    amplitudes,
    decay,
    decays,
    measurement,
    power_law_amplitude,
    times,
)

from slipmode import rom

POWER = {"bands": BANDS, "law": "power", "cross": False}


def identified(broken, seed=3):
    """Sound records with a third one that is not."""
    signals = decays(seed, 4)
    signals[2] = broken(signals[2], np.random.default_rng(seed))
    return rom.identify(measurement(signals), **POWER)


def replaced(first, last, value):
    def broken(y, _):
        y = y.copy()
        y[first:last] = y[first] if value == "held" else value
        return y

    return broken


def blow(at, size):
    """Another blow changes all amplitudes by `size` at a time."""

    def broken(_, rng):
        t, first = times(), amplitudes(rng, 1)[0]
        y = 1e-3 * rng.standard_normal(t.size)
        for a0, mode in zip(first, TRUE, strict=True):
            there = power_law_amplitude(at, a0, *mode) + size * np.exp(2j * np.pi * rng.random())
            after = power_law_amplitude(np.maximum(t - at, 0.0), there, *mode)
            y += np.where(t < at, power_law_amplitude(t, a0, *mode), after).real
        return y

    return broken


def tone(frequency, size):
    return lambda y, _: y + size * np.cos(2.0 * np.pi * frequency * times() + 1.0)


def before_the_blow(y, _):
    return np.concatenate([0.02 * np.cos(770.0 * times()[:1000]), y[:-1000]])


def trigger(y, rng):
    """Quiet, then a blow of 6 ms, then the decay."""
    y = np.concatenate([np.zeros(400), y[:-400]])
    y[394:406] += 2.0 * np.hanning(12)
    return y + 1e-3 * rng.standard_normal(y.size)


EXCLUDED = {
    "clipped": (lambda y, _: np.clip(y, -0.6 * abs(y).max(), 0.6 * abs(y).max()), "clipped"),
    "clipped on one side": (lambda y, _: np.minimum(y, 0.7 * y.max()), "clipped"),
    "NaN": (replaced(700, 703, np.nan), "3 samples are no finite numbers, the first at 0.35 s"),
    "zeros": (replaced(1200, 1240, 0.0), "drops out at 0.6 s: 40 samples are equal"),
    "held": (replaced(1200, 1220, "held"), "drops out at 0.6 s: 20 samples are equal"),
    "blow after 20 ms": (blow(0.02, 0.6), "no decay fits it"),
    "noise": (lambda y, rng: rng.standard_normal(y.size), "there is no decay above the noise"),
    "steady": (
        lambda y, _: np.cos(770.0 * times()) + 0.5 * np.cos(1530.0 * times()),
        "does not decay",
    ),
    "constant": (lambda y, _: np.zeros_like(y), "constant"),
    "short": (lambda y, _: y[:300], "too short"),
}
USED_IN_PART = {  # change, note, range of the start and of the end [s]
    "blow": (blow(0.7, 0.3), "another blow", (0.75, 0.9), (2.4, 2.5)),
    "late blow": (blow(2.0, 0.3), "another blow", (0.0, 0.0), (1.8, 2.0)),
    "before": (before_the_blow, "vibrates before the blow", (0.5, 0.52), (2.4, 2.5)),
    "hum": (tone(50.0, 0.05), "tone at 50 Hz", (0.0, 0.0), (2.4, 2.5)),
    "hum in a band": (tone(230.0, 0.02), "tone at 230 Hz", (0.0, 0.0), (2.4, 2.5)),
    "offset": (lambda y, _: y + 0.2, "offset or drift", (0.0, 0.0), (2.4, 2.5)),
    "padded": (replaced(4500, 5000, np.nan), "500 samples, from 2.25 s on", (0, 0), (2.2, 2.25)),
    "trigger": (trigger, None, (0.2, 0.21), (2.4, 2.5)),
}


def assert_the_law_is_true(found):
    assert all(r.use == "fitted" and not r.notes for r in found.records if r.name != "hit3")
    assert found.parameters["delta_0_A"] == pytest.approx(TRUE[0, 0], rel=0.01)
    assert found.parameters["p_A"] == pytest.approx(TRUE[0, 4], rel=0.02)


@pytest.mark.oracle
@pytest.mark.parametrize("name", EXCLUDED)
def test_broken_records_are_excluded_with_the_reason(name):
    broken, reason = EXCLUDED[name]
    found = identified(broken)
    assert found.records[2].use == "excluded"
    assert reason in found.records[2].notes[-1]
    assert_the_law_is_true(found)


@pytest.mark.oracle
@pytest.mark.parametrize("name", USED_IN_PART)
def test_disturbed_records_are_used_in_part_and_say_so(name):
    broken, note, start, end = USED_IN_PART[name]
    found = identified(broken)
    report = found.records[2]
    assert report.use == "fitted"
    assert any(note in line for line in report.notes) if note else not report.notes
    assert start[0] <= report.start <= start[1]
    assert end[0] <= report.end <= end[1]
    assert_the_law_is_true(found)


def assert_sound(found):
    assert not [r for r in found.records if r.use != "fitted" or r.notes]


@pytest.mark.parametrize(
    ("rate", "noise", "bits"), [(700.0, 1e-4, 0), (20000.0, 2e-2, 0), (RATE, 1e-3, 8)]
)
def test_noise_and_converters_of_few_bits_are_no_defects(rate, noise, bits):
    rng = np.random.default_rng(5)
    signals = np.array([decay(rng, t=times(rate=rate), noise=noise) for _ in range(4)])
    if bits:
        signals = np.round(signals * 2**bits / 4.0) * 4.0 / 2**bits
    assert_sound(rom.identify(measurement(signals, rate), **POWER))


@pytest.mark.oracle
def test_other_modes_are_filtered_out():
    """A mode of 400 Hz of the same size, and mode B for one band."""
    other = np.array([6.0, 2.0 * np.pi * 400.0, 1e-3, 0.0, 1.0])
    found = rom.identify(measurement(decays(7, 4, modes=[*TRUE, other])), **POWER)
    assert all("largest at 400" in r.notes[-1] for r in found.records)
    assert found.parameters["delta_0_A"] == pytest.approx(TRUE[0, 0], rel=0.01)
    assert found.parameters["delta_0_B"] == pytest.approx(TRUE[1, 0], rel=0.01)
    one = rom.identify(measurement(decays(7, 4)), bands=BANDS[:1], law="power")
    assert all("largest at 243" in r.notes[-1] for r in one.records)
    assert one.parameters["delta_0_A"] == pytest.approx(TRUE[0, 0], rel=0.01)
