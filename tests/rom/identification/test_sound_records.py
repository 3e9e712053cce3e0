"""Sound records have no notes; measurements and bands that cannot be identified are refused."""

import numpy as np
import pytest
from measured.decays import BANDS, RATE, TRUE, decay, decays, measurement, times

from slipmode import rom

POWER = {"bands": BANDS, "law": "power", "cross": False}


@pytest.mark.parametrize("zeta", [0.001, 0.01, 0.02])
@pytest.mark.parametrize("frequency", [20.0, 3000.0])
def test_modes_of_other_frequencies_and_damping(frequency, zeta):
    """Also those that have decayed long before the end of the record."""
    omega = 2.0 * np.pi * frequency
    delta = zeta * omega
    mode = np.array([[delta, omega, delta, 3.0 * delta, 1.3]])
    rate, duration = 10.0 * frequency, 15.0 / delta
    signals = decays(9, 4, modes=mode, t=times(duration, rate))
    found = rom.identify(
        measurement(signals, rate), bands=[(0.8 * frequency, 1.2 * frequency)], law="power"
    )
    assert not [r for r in found.records if r.use != "fitted" or r.notes]
    assert found.parameters["delta_0_A"] == pytest.approx(delta, rel=0.01)
    assert found.parameters["p_A"] == pytest.approx(1.3, rel=0.01)


@pytest.mark.parametrize(
    ("rate", "noise"), [(700.0, 1e-4), (700.0, 2e-2), (5120.0, 3e-3), (20000.0, 2e-2)]
)
def test_sound_records_have_no_notes(rate, noise):
    rng = np.random.default_rng(5)
    signals = [decay(rng, t=times(rate=rate), noise=noise) for _ in range(4)]
    found = rom.identify(measurement(signals, rate), **POWER)
    assert not [r for r in found.records if r.use != "fitted" or r.notes]


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_converters_of_few_bits_do_not_count_as_clipping(bits):
    step = 4.0 / 2**bits
    signals = [np.round(y / step) * step for y in decays(6, 4)]
    found = rom.identify(measurement(signals), **POWER)
    assert not [r for r in found.records if r.use != "fitted" or r.notes]


def test_other_modes_are_filtered_out():
    """A mode of 400 Hz of the same size, and mode B for one band."""
    other = np.array([6.0, 2.0 * np.pi * 400.0, 1e-3, 0.0, 1.0])
    signals = decays(7, 4, modes=[*TRUE, other])
    found = rom.identify(measurement(signals), **POWER)
    assert all("largest at 400" in r.notes[-1] for r in found.records)
    assert found.parameters["delta_0_A"] == pytest.approx(TRUE[0, 0], rel=0.01)
    assert found.parameters["delta_0_B"] == pytest.approx(TRUE[1, 0], rel=0.01)
    one = rom.identify(measurement(decays(7, 4)), bands=BANDS[:1], law="power")
    assert all("largest at 243" in r.notes[-1] for r in one.records)
    assert one.parameters["delta_0_A"] == pytest.approx(TRUE[0, 0], rel=0.01)


REFUSED = {
    "no decay": ([(150.0, 200.0)], RATE, "bands: 150 to 200 Hz has no decay of a mode"),
    "two modes": ([(100.0, 260.0)], RATE, "bands: 100 to 260 Hz has peaks at"),
    "sampling": ([(100.0, 140.0)], 300.0, "bands: 140 Hz needs a sampling rate of at least 350"),
    "mode at the upper edge": (
        [(100.0, 123.5)],
        RATE,
        "bands: 100 to 123.5 Hz has its mode at 122.4 Hz, where the filter of the band removes",
    ),
    "mode at the lower edge": ([(122.0, 140.0)], RATE, "choose a band around the mode"),
    "overlap": ([(100, 140), (130, 260)], RATE, "must not overlap"),
    "order": (
        [(225, 260), (100, 140)],
        RATE,
        "must not overlap, and the lower band must be first",
    ),
    "negative": ([(-1, 140)], RATE, "must be 0 < lower < upper"),
    "one number": ([100], RATE, "one or two pairs of frequencies"),
    "three": ([(1, 2), (3, 4), (5, 6)], RATE, "one or two pairs of frequencies"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bands_that_cannot_be_identified_are_refused(name):
    bands, rate, message = REFUSED[name]
    signals = [decay(np.random.default_rng(1), t=times(rate=rate))]
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.identify(measurement(signals, rate), bands=bands)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_measurement_without_usable_records_is_refused_with_the_reasons():
    signals = [np.minimum(y, 0.7 * y.max()) for y in decays(2, 2)]
    with pytest.raises(rom.SlipmodeError, match=r"no record can be fitted \(hit1: it is clipped"):
        rom.identify(measurement(signals), **POWER)
    with pytest.raises(rom.SlipmodeError, match="all are held out"):
        rom.identify(measurement(decays(2, 2)), hold_out=[1, "hit2"], **POWER)


def test_fewer_data_than_parameters_are_refused():
    short = decays(2, 1, t=times(0.6), noise=0.01, start=(1.0, 0.1))
    with pytest.raises(rom.SlipmodeError, match="law = quadratic with cross effects: has 16"):
        rom.identify(measurement(short), bands=BANDS, law="quadratic", cross=True)
