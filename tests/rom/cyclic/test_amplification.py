"""Amplification factors of drawn disks: against full order, bounds, and their statistics."""

import numpy as np
import pytest
import scipy.linalg
import scipy.stats
from cyclic.full_annulus import excitation, law_of_all

from slipmode import rom
from slipmode.rom import full

SECTORS, ORDER, HIGHEST = 12, 3, 1e5
DISK = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6))
LAW = rom.Jenkins(1.0, 5e4)
FORCE = [0.0, 0.0, 4.0]


def frequencies(count):
    return rom.travelling_wave(DISK, LAW, ORDER).frequency * np.linspace(0.95, 1.02, count)


def test_the_worst_of_some_disks_is_that_of_full_order():
    omega = frequencies(40)
    patterns = rom.random_mistuning(20, SECTORS, 0.04, seed=1)
    disks = rom.MistunedDisk(DISK, LAW, patterns, HIGHEST)
    found = disks.amplification(omega, ORDER, FORCE, dof=2)
    responses = disks.response(omega, ORDER, FORCE, local=True)
    worst, at, _ = np.unravel_index(responses.amplitude(2).argmax(), (20, 40, SECTORS))
    tuned = rom.MistunedDisk(DISK, LAW, np.zeros(SECTORS), HIGHEST)
    at_tuned = tuned.response(omega, ORDER, FORCE, local=True).amplitude(2)[0].max(axis=1).argmax()
    peaks = []
    for deviation, frequency in (
        (patterns[worst], omega[at]),
        (np.zeros(SECTORS), omega[at_tuned]),
    ):
        structure = DISK.annulus(deviation)
        forced = excitation(DISK, structure, ORDER, frequency, FORCE)
        outputs, law = range(2, structure.n_dofs, 3), law_of_all(DISK, LAW)
        motion = full.steady_amplitude(structure, law, forced, outputs=outputs).amplitude[0]
        peaks.append(2.0 * np.abs(motion).max())
    assert found.factor.size == 20
    assert abs(found.factor[-1] * peaks[1] / peaks[0] - 1.0) < 1e-3  # measured 3e-4
    assert abs(found.tuned / peaks[1] - 1.0) < 1e-3  # measured 1e-4


def test_linear_disks_stay_below_whitehead_s_bound():
    disks = rom.MistunedDisk(
        DISK, rom.Jenkins(1e3, 5e4), rom.random_mistuning(200, SECTORS, 0.03, seed=2), HIGHEST
    )
    linear = disks.amplification(frequencies(60), ORDER, FORCE, dof=2)
    assert linear.whitehead == pytest.approx(0.5 * (1.0 + np.sqrt(12.0)))
    assert linear.factor[-1] < linear.whitehead  # measured 1.49 < 2.23
    assert linear.extreme_quantile(0.999)[0] < linear.whitehead  # measured 1.48
    assert np.median(linear.factor) > 1.15  # measured 1.20


def test_batches_of_patterns_change_nothing(monkeypatch):
    disks = rom.MistunedDisk(DISK, LAW, rom.random_mistuning(5, SECTORS, 0.04), HIGHEST)
    once = disks.amplification(frequencies(20), ORDER, FORCE, dof=2)
    monkeypatch.setattr("slipmode.rom.cyclic.mistuned.mistuned_disk._MOST_NUMBERS", 1500)
    batches = disks.amplification(frequencies(20), ORDER, FORCE, dof=2)
    np.testing.assert_allclose(batches.factor, once.factor, rtol=1e-6)


def test_intervals_contain_the_quantile_as_often_as_they_say():
    true = scipy.stats.genextreme(0.2, loc=1.4, scale=0.1)
    rng = np.random.default_rng(5)
    inside = {"order": 0, "fit": 0, "band": 0}
    for _ in range(100):
        disks = rom.Amplification(np.sort(true.rvs(100, random_state=rng)), 1.0, 24)
        _, low, high = disks.quantile(0.95)
        inside["order"] += low < true.ppf(0.95) < high
        _, low, high = disks.extreme_quantile(0.99)
        inside["fit"] += low < true.ppf(0.99) < high
        _, low, high = disks.distribution()
        inside["band"] += low[60] < true.cdf(disks.factor[60]) < high[60]
    # measured 97, 93 and 92 of 100
    assert all(count >= 90 for count in inside.values()), inside


def test_the_extreme_value_distribution_is_found():
    true = scipy.stats.genextreme(0.2, loc=1.4, scale=0.1)
    disks = rom.Amplification(np.sort(true.rvs(20000, random_state=1)), 1.0, 24)
    for probability in (0.5, 0.99, 0.9999):
        found, expected = disks.extreme_value.ppf(probability), true.ppf(probability)
        assert abs(found - expected) < 0.01 * expected  # measured 0.0007, 0.0033, 0.0086


def test_too_few_disks_have_no_limit():
    disks = rom.Amplification(np.array([1.1, 1.2, 1.3, 1.5]), 1.0, 24)
    assert disks.quantile(0.99)[2] == np.inf
    assert disks.quantile(0.01)[1] == 0.0
    with pytest.raises(rom.SlipmodeError, match=r"probability: must be between 0 and 1, got 1\.0"):
        disks.quantile(1.0)


@pytest.mark.parametrize("factor", [[1.2], [1.1, 1.3], [1.2, 1.2, 1.2]])
def test_factors_that_determine_no_extreme_value_distribution_are_refused(factor):
    disks = rom.Amplification(np.array(factor), 1.0, 24)
    for call in (lambda: disks.extreme_value, lambda: disks.extreme_quantile(0.99)):
        with pytest.raises(rom.SlipmodeError, match=r"^factor: .* at least 3 factors"):
            call()


def test_three_disks_have_an_extreme_value_distribution():
    found = rom.Amplification(np.array([1.1, 1.2, 1.4]), 1.0, 24).extreme_quantile(0.99)
    assert found[1] <= found[0] <= found[2]


def test_frequencies_of_blades_become_stiffnesses():
    """Of the blade of the lumped disk by itself, clamped at its root."""
    mass, blade = DISK.mass.toarray()[1:3, 1:3], DISK.blade.toarray()[1:3, 1:3]
    deviation = np.array([0.04, -0.03, 0.0])
    square = [scipy.linalg.eigvalsh((1.0 + each) * blade, mass)[0] for each in deviation]
    nominal = np.sqrt(scipy.linalg.eigvalsh(blade, mass)[0])
    found = rom.stiffness_deviation(np.sqrt(square), nominal)
    np.testing.assert_allclose(found, deviation, atol=1e-12)


def test_drawn_patterns_have_their_deviation():
    for uniform in (False, True):
        drawn = rom.random_mistuning(2000, 24, 0.04, uniform=uniform)
        assert abs(drawn.std() / 0.04 - 1.0) < 0.01  # measured 0.0016
        assert np.array_equal(drawn, rom.random_mistuning(2000, 24, 0.04, uniform=uniform))
    assert np.abs(drawn).max() < 0.04 * np.sqrt(3.0)


def test_wrong_patterns_are_refused():
    for arguments, message in (
        ((0, 24, 0.04), "patterns: must be an integer >= 1, got 0"),
        ((10, 24, 0.5), "deviation: must be above 0 and at most 0.2, got 0.5"),
    ):
        with pytest.raises(rom.SlipmodeError, match=message):
            rom.random_mistuning(*arguments)
    with pytest.raises(rom.SlipmodeError, match="frequency: must be finite numbers > 0"):
        rom.stiffness_deviation([200.0, 0.0])
    with pytest.raises(rom.SlipmodeError, match="nominal: must be a finite number > 0"):
        rom.stiffness_deviation([200.0], -1.0)
