"""Intervals by the scatter between records contain the true parameters as often as they say."""

import numpy as np
import pytest
from measured.decays import BANDS, TRUE, decay, decays, measurement, parameters

from slipmode import rom
from slipmode.rom.identification.decay_flow import Decays
from slipmode.rom.identification.fit import fit


def inside(seed, noise, scatter, records=9):
    """Which of ten true parameters are in their interval, for a drawn law."""
    rng = np.random.default_rng(seed)
    modes = TRUE * rng.uniform(0.7, 1.4, TRUE.shape)
    modes[:, 1] = TRUE[:, 1]
    signals = [decay(rng, scattered(rng, modes, scatter), noise=noise) for _ in range(records)]
    found = rom.identify(measurement(signals), bands=BANDS, law="power", cross=False)
    true = parameters(found, modes)
    return [low <= true[name] <= high for name, (low, high) in found.interval.items()]


def scattered(rng, modes, scatter):
    """Rates of a record: damping, its growth and the shift of frequency scatter."""
    own = modes.copy()
    own[:, [0, 2, 3]] *= 1.0 + scatter * rng.standard_normal((len(modes), 3))
    return own


@pytest.mark.slow
def test_intervals_contain_the_true_parameters():
    hits = np.array([inside(seed, 1e-2, 0.0) for seed in range(6)])
    assert hits.mean() > 0.85  # 0.95 of 30 sets


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "scatter"), [(1e-2, 0.0), (1e-3, 0.03)])
def test_intervals_of_thirty_sets_contain_the_true_parameters(noise, scatter):
    hits = np.array([inside(seed, noise, scatter) for seed in range(30)])
    assert hits.mean() > 0.9


def test_one_step_of_the_jackknife_is_close_to_fits_without_a_record():
    rng = np.random.default_rng(2)
    signals = [decay(rng, scattered(rng, TRUE, 0.03)) for _ in range(6)]
    found = rom.identify(measurement(signals), bands=BANDS, law="power", cross=False)
    decays, law = found.source.decays, found.law
    assert isinstance(decays, Decays)
    start = np.array(list(_starts(found))).T
    for k in (0, 3):
        others = [i for i in range(6) if i != k]
        full = fit(decays.only(others), law.form, law.values, start[:, others]).law.values
        step = found.uncertainty.left_out[k].values
        free = law.form.free
        deviation = np.array(list(found.deviation.values()))
        assert np.abs((full - step)[free] / deviation).max() < 0.3


def _starts(found):
    for report in found.records:
        made = found.predict(report.name, extrapolate=True)
        yield made.amplitude[0] * np.exp(1j * made.phase[0])


def test_the_misfit_is_that_of_the_law():
    """Of mode A, whose damping grows from 0.4 to 1.0 1/s."""
    data = measurement(decays(0))
    power, linear = (rom.identify(data, bands=BANDS, law=law) for law in ("power", "linear"))
    misfit = [np.sqrt(found.uncertainty.misfit[0, 0]) for found in (power, linear)]
    assert misfit[0] < 3e-3  # 4e-4 1/s
    assert misfit[1] > 0.05  # 0.11 1/s
    bands = [found.backbone(0, [0.3]).damping_deviation[0] for found in (power, linear)]
    assert bands[1] > 10.0 * bands[0]


@pytest.mark.slow
def test_laws_that_predict_as_well_widen_the_intervals():
    data = measurement(decays(3))
    alone = rom.identify(data, bands=BANDS, law="power", cross=False)
    chosen = rom.identify(data, bands=BANDS)
    assert chosen.law.form == alone.law.form
    assert len(chosen.uncertainty.laws) > 1
    variance = [found.uncertainty.variance(lambda law: law.values)[0] for found in (alone, chosen)]
    assert variance[1] > variance[0]


def test_bands_of_predictions_contain_the_misfit_of_the_law():
    """A law with constant rates predicts a decay whose damping grows with its amplitude."""
    data = measurement(decays(0, 7))
    linear, power = (
        rom.identify(data, bands=BANDS, law=law, hold_out=[7]).predict(7, True)
        for law in ("linear", "power")
    )
    phase = [np.interp(linear.times, power.times, each) for each in power.phase.T]
    off = np.abs(np.transpose(phase) - linear.phase) / linear.phase_deviation
    size = [np.interp(linear.times, power.times, each) for each in power.amplitude.T]
    changed = np.abs(np.transpose(size) - linear.amplitude) / linear.amplitude_deviation
    # 0.81; by the scatter between records alone 0.54
    assert np.mean(np.stack([off, changed]) < 2.0) > 0.75
