"""Broken records are named, and excluded or used in part; sound ones are not."""

import numpy as np
import pytest
from measured.decays import BANDS, TRUE, decay_with_blow, decays, measurement, times

from slipmode import rom
from slipmode.rom.identification.records.defects import remove_tones

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


def clipped(y, _):
    return np.clip(y, -0.6 * abs(y).max(), 0.6 * abs(y).max())


def clipped_above(y, _):
    return np.minimum(y, 0.7 * y.max())


def blow(at, size):
    return lambda _, rng: decay_with_blow(rng, at, size)


def tone(frequency, size):
    return lambda y, _: y + size * np.cos(2.0 * np.pi * frequency * times() + 1.0)


def noise_alone(y, rng):
    return rng.standard_normal(y.size)


def steady(y, rng):
    return np.cos(770.0 * times()) + 0.5 * np.cos(1530.0 * times())


def before_the_blow(y, _):
    return np.concatenate([0.02 * np.cos(770.0 * times()[:1000]), y[:-1000]])


def trigger(y, rng):
    """Quiet, then a blow of 6 ms, then the decay."""
    y = np.concatenate([np.zeros(400), y[:-400]])
    y[394:406] += 2.0 * np.hanning(12)
    return y + 1e-3 * rng.standard_normal(y.size)


EXCLUDED = {
    "clipped": (clipped, "clipped"),
    "clipped on one side": (clipped_above, "clipped"),
    "NaN": (replaced(700, 703, np.nan), "3 samples are no finite numbers, the first at 0.35 s"),
    "zeros": (replaced(1200, 1240, 0.0), "drops out at 0.6 s: 40 samples are equal"),
    "held": (replaced(1200, 1220, "held"), "drops out at 0.6 s: 20 samples are equal"),
    "blow after 20 ms": (blow(0.02, 0.6), "no decay fits it"),
    "blow after 50 ms": (blow(0.05, 0.5), "no decay fits it"),
    "noise": (noise_alone, "there is no decay above the noise"),
    "steady": (steady, "does not decay"),
    "constant": (lambda y, _: np.zeros_like(y), "constant"),
    "short": (lambda y, _: y[:300], "too short"),
}
USED_IN_PART = {
    "blow": (blow(0.7, 0.3), "another blow", (0.75, 0.9), (2.4, 2.5)),
    "small blow": (blow(0.7, 0.1), "another blow", (0.75, 0.9), (2.4, 2.5)),
    "late blow": (blow(2.0, 0.3), "another blow", (0.0, 0.0), (1.8, 2.0)),
    "tiny blow": (blow(0.7, 0.03), "check it for disturbances", (0.0, 0.0), (2.4, 2.5)),
    "before": (before_the_blow, "vibrates before the blow", (0.5, 0.52), (2.4, 2.5)),
    "hum": (tone(50.0, 0.05), "tone at 50 Hz", (0.0, 0.0), (2.4, 2.5)),
    "hum in a band": (tone(230.0, 0.02), "tone at 230 Hz", (0.0, 0.0), (2.4, 2.5)),
    "offset": (lambda y, _: y + 0.2, "offset or drift", (0.0, 0.0), (2.4, 2.5)),
    "padded": (replaced(4500, 5000, np.nan), "500 samples, from 2.25 s on", (0, 0), (2.2, 2.25)),
}


def assert_others_are_sound(found):
    assert all(r.use == "fitted" and not r.notes for r in found.records if r.name != "hit3")
    delta_0, p = found.parameters["delta_0_A"], found.parameters["p_A"]
    assert delta_0 == pytest.approx(TRUE[0, 0], rel=0.01)  # 0.1 % without the broken record
    assert p == pytest.approx(TRUE[0, 4], rel=0.02)


@pytest.mark.parametrize("name", EXCLUDED)
def test_broken_records_are_excluded_with_the_reason(name):
    broken, reason = EXCLUDED[name]
    found = identified(broken)
    report = found.records[2]
    assert report.use == "excluded"
    assert reason in report.notes[-1]
    assert_others_are_sound(found)


@pytest.mark.parametrize("name", USED_IN_PART)
def test_disturbed_records_are_used_in_part_and_say_so(name):
    broken, note, start, end = USED_IN_PART[name]
    found = identified(broken)
    report = found.records[2]
    assert report.use == "fitted"
    assert any(note in line for line in report.notes), report.notes
    assert start[0] <= report.start <= start[1]
    assert end[0] <= report.end <= end[1]
    if name != "tiny blow":  # it changes p by 9 %
        assert_others_are_sound(found)


def test_a_decay_starts_after_its_blow():
    report = identified(trigger).records[2]
    assert report.notes == ()
    assert 0.2 < report.start < 0.21


def stuck_joint(start, rate=1000.0, limit=0.3):
    """A joint slips at 48 Hz and more until it sticks; then a free vibration of 50 Hz decays."""
    t = np.arange(round(8.0 * rate)) / rate
    sticks = (start - limit) / 1.2
    size = np.where(t < sticks, start - 1.2 * t, limit * np.exp(-0.02 * (t - sticks)))
    hertz = np.where(t < sticks, 48.0 + 2.0 * limit / np.maximum(size, limit), 50.0)
    return size * np.cos(2.0 * np.pi * np.cumsum(hertz) / rate)


@pytest.mark.parametrize("start", [0.35, 0.45])
def test_the_late_vibration_of_a_stuck_joint_is_no_steady_tone(start):
    """It is 2 Hz from the mode with slip. A tone of constant size there is steady."""
    rng, hum = np.random.default_rng(0), tone_of(50.0)
    joint = stuck_joint(start) + 1e-4 * rng.standard_normal(8000)
    assert remove_tones(measurement([joint], 1000.0)[1], np.array([48.0]))[1] == ()
    assert len(remove_tones(measurement([hum], 1000.0)[1], np.array([48.0]))[1]) == 1


def tone_of(frequency):
    t = np.arange(8000) / 1000.0
    mode = np.exp(-2.0 * t) * np.cos(2.0 * np.pi * 48.0 * t)
    return mode + 0.3 * np.cos(2.0 * np.pi * frequency * t)
