"""A law is not claimed where measured rates deviate systematically from it."""

import numpy as np
import pytest
from measured.decays import BANDS, TRUE, decays, measurement

from slipmode import rom


def slider(rng, duration=4.0, rate=1000.0):
    """A decay whose damping steps up where a slider slips, and falls again; closed form.

    Below s the rate is d, above it d + 4 c s (a - s) / a^2, integrated by steps of 1 ms.
    """
    d, s = 0.5, 0.25
    c = 0.8
    t = np.arange(round(duration * rate)) / rate
    a, sizes = rng.uniform(0.5, 1.0), []
    for _ in t:
        sizes.append(a)
        middle = a * (1.0 - 0.5 * friction(a, d, c, s) / rate)
        a *= np.exp(-friction(middle, d, c, s) / rate)
    wave = np.cos(2.0 * np.pi * 60.0 * t + rng.uniform(0.0, 6.0))
    return np.array(sizes) * wave + 1e-3 * rng.standard_normal(t.size)


def friction(a, d, c, s):
    return d + (4.0 * c * s * (a - s) / a**2 if a > s else 0.0)


@pytest.mark.parametrize("seed", range(2))
def test_a_law_outside_the_set_is_not_claimed(seed):
    rng = np.random.default_rng(seed)
    found = rom.identify(measurement([slider(rng) for _ in range(5)], 1000.0), bands=[(50, 70)])
    assert len(found.deviations) == 1 and "mode A" in found.deviations[0]
    assert set(found.parameters) - {"delta_0_A", "omega_0_A"} <= set(found.unidentified)
    low, high = found.interval["delta_0_A"]
    assert low < 0.5 < high
    size = np.array([0.1, 0.2, 0.4, 0.5])
    line = found.backbone(0, size)
    true = np.array([friction(a, 0.5, 0.8, 0.25) for a in size])
    off = np.abs(line.damping * line.frequency - true) / (line.damping_deviation * line.frequency)
    assert (off < 2.0).all()


def test_a_law_that_describes_one_of_two_modes_is_claimed_for_it():
    """Mode B has constant rates, which a linear law has; the damping of mode A grows."""
    modes = TRUE.copy()
    modes[1, 2:4] = 1e-9
    found = rom.identify(measurement(decays(4, modes=modes)), bands=BANDS, law="linear")
    assert len(found.deviations) == 1 and "mode A" in found.deviations[0]
    width = {m: np.diff(found.interval[f"delta_0_{m}"])[0] for m in "AB"}
    assert width["A"] > 10.0 * width["B"]


@pytest.mark.parametrize(("seed", "noise", "records"), [(0, 1e-2, 6), (1, 1e-2, 3), (2, 1e-3, 3)])
def test_a_law_within_noise_is_claimed(seed, noise, records):
    found = rom.identify(measurement(decays(seed, records, noise=noise)), bands=BANDS, law="power")
    assert not found.deviations
