"""Disks whose blades differ: steady states of all sectors, and amplification factors."""

import numpy as np
import pytest
import scipy.linalg
import scipy.stats
from cyclic.ring import MASSES, TIPS, TWO, around, ring, steady_wave

from slipmode import rom

SECTORS, ORDER = 12, 3
FORCE = np.array([0.0, 0.0, 6.0])
HIGHEST = 1e5  # all modes of the lumped disk
DEVIATION = 0.04 * np.random.default_rng(3).standard_normal(SECTORS)
# no mode near three times the frequency of the first family
DISK = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6))
LAW = rom.Jenkins(1.0, 5e4)
internal = pytest.mark.filterwarnings("ignore:internal resonance")


def near(disk, law, *parts):
    return rom.travelling_wave(disk, law, ORDER).frequency * np.array(parts)


@internal
@pytest.mark.oracle
@pytest.mark.parametrize(
    # `with_local` bounds what contacts do to each other at higher harmonics, 0.6 % of lumped
    # disks away from internal resonances
    ("contacts", "law", "with_local"),
    [
        (TIPS, rom.Jenkins(1.0, 2e4), 0.01),
        pytest.param(TIPS, rom.Jenkins(1.0, 2e5), 0.01, marks=pytest.mark.slow),
        pytest.param(TWO, rom.Jenkins((1.0, 0.6), (5e4, 3e4)), None, marks=pytest.mark.slow),
        (TIPS, rom.Sliders((0.3, 0.5, 1.0), (5e4, 3e4, 2e4)), None),
    ],
)
def test_every_blade_moves_as_in_the_ring(contacts, law, with_local):
    disk = rom.lumped_disk(SECTORS, 1e-5, **contacts)
    omega = near(disk, law, 0.98, 0.995)
    disks = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    c, own = steady_wave(
        ring(SECTORS, law, 1e-5, 2e6, contacts, DEVIATION), ORDER, omega[-1], FORCE
    )
    expected = c.reshape(SECTORS, 3)
    size = np.abs(expected).max()
    exact = disks.response(omega, ORDER, FORCE).displacement[0, -1]
    assert np.abs(exact - expected).max() < 1e-4 * size + own
    if with_local:
        local = disks.response(omega, ORDER, FORCE, local=True).displacement[0, -1]
        assert np.abs(local - expected).max() < with_local * size + own


@pytest.mark.slow
@pytest.mark.oracle
def test_strong_shrouds_near_an_internal_resonance_converge():
    """Where Newton's method without secants did not converge."""
    disk, law = rom.lumped_disk(24, 1e-5), rom.Jenkins(4.0, 2e5)
    deviation = 0.02 * np.random.default_rng(3).standard_normal(24)
    (omega,) = near(disk, law, 0.972)
    disks = rom.MistunedDisk(disk, law, deviation, HIGHEST)
    found = disks.response(omega, ORDER, {2: 10.0}).displacement[0, 0]
    system = ring(24, law, 1e-5, deviation=deviation)
    expected, own = steady_wave(system, ORDER, omega, [0.0, 0.0, 10.0])
    size = np.abs(expected).max()
    assert np.abs(found.ravel() - expected).max() < 1e-3 * size + own


@pytest.mark.oracle
def test_disks_of_stuck_contacts_have_the_linear_response():
    """Also if modes from 9200 rad/s respond statically: (1200 / 9200)^2 of it is off."""
    law, patterns = rom.Jenkins(1e4, 5e4), np.array([DEVIATION, -DEVIATION, 0.0 * DEVIATION])
    omega = near(DISK, law, 0.97, 1.01)
    load = 0.5 * around(FORCE, ORDER, SECTORS)
    for highest, neglected in ((HIGHEST, 1e-10), (8000.0, (1200.0 / 9200.0) ** 2)):
        disks = rom.MistunedDisk(DISK, law, patterns, highest)
        found = disks.response(omega, ORDER, FORCE).displacement.reshape(3, 2, -1)
        for i, pattern in enumerate(patterns):
            system = ring(SECTORS, law, 1e-5, 4e6, deviation=pattern)
            for j, each in enumerate(omega):
                dynamic = system.stuck() - each**2 * system.M + 1j * each * system.C
                expected = np.linalg.solve(dynamic, load)
                off = np.abs(found[i, j] - expected).max()
                # of the higher modes, which have less than a tenth of the motion
                assert off < 0.1 * neglected * np.abs(expected).max()


@pytest.mark.oracle
def test_linear_factors_are_those_of_all_sectors_and_below_whiteheads():
    law, patterns = rom.Jenkins(1e4, 5e4), rom.random_mistuning(20, SECTORS, 0.03, seed=2)
    omega = near(DISK, law, *np.linspace(0.95, 1.02, 25))
    found = rom.MistunedDisk(DISK, law, patterns, HIGHEST).amplification(
        omega, ORDER, FORCE, dof=2
    )
    load, peaks = around(FORCE, ORDER, SECTORS), []
    for pattern in (0.0, *patterns):
        system = ring(SECTORS, law, 1e-5, 4e6, deviation=pattern)
        dynamic = [system.stuck() - w**2 * system.M + 1j * w * system.C for w in omega]
        peaks.append(max(np.abs(np.linalg.solve(each, load)[2::3]).max() for each in dynamic))
    assert found.tuned == pytest.approx(peaks[0], rel=1e-8)
    np.testing.assert_allclose(found.factor, np.sort(peaks[1:]) / peaks[0], rtol=1e-8)
    assert found.whitehead == pytest.approx(0.5 * (1.0 + np.sqrt(SECTORS)))  # Whitehead 1966
    assert 1.2 < found.factor[-1] < found.whitehead
    assert found.extreme_quantile(0.999)[0] < found.whitehead


@pytest.mark.slow
@pytest.mark.oracle
def test_the_worst_of_some_disks_with_friction_is_that_of_the_ring():
    omega = near(DISK, LAW, *np.linspace(0.95, 1.02, 40))
    patterns = rom.random_mistuning(20, SECTORS, 0.04, seed=1)
    disks = rom.MistunedDisk(DISK, LAW, patterns, HIGHEST)
    found = disks.amplification(omega, ORDER, FORCE, dof=2)
    amplitude = disks.response(omega, ORDER, FORCE, local=True).amplitude(2)
    worst, at, _ = np.unravel_index(amplitude.argmax(), amplitude.shape)
    tuned = rom.MistunedDisk(DISK, LAW, np.zeros(SECTORS), HIGHEST)
    at_tuned = tuned.response(omega, ORDER, FORCE, local=True).amplitude(2)[0].max(axis=1).argmax()
    peaks = []
    for deviation, w in ((patterns[worst], omega[at]), (0.0, omega[at_tuned])):
        c, _ = steady_wave(ring(SECTORS, LAW, 1e-5, 4e6, deviation=deviation), ORDER, w, FORCE)
        peaks.append(2.0 * np.abs(c[2::3]).max())
    # contacts are local: 0.6 % at most on lumped disks
    assert abs(found.factor[-1] * peaks[1] / peaks[0] - 1.0) < 6e-3
    assert abs(found.tuned / peaks[1] - 1.0) < 6e-3


@pytest.mark.oracle
def test_intervals_contain_the_quantile_as_often_as_they_say():
    """Of a known distribution: 95 % of 100 draws, 90 at least with a probability of 0.99."""
    true, rng = scipy.stats.genextreme(0.2, loc=1.4, scale=0.1), np.random.default_rng(5)
    inside = {"order": 0, "fit": 0, "band": 0}
    for _ in range(100):
        disks = rom.Amplification(np.sort(true.rvs(100, random_state=rng)), 1.0, 24)
        _, low, high = disks.quantile(0.95)
        inside["order"] += low < true.ppf(0.95) < high
        _, low, high = disks.extreme_quantile(0.99)
        inside["fit"] += low < true.ppf(0.99) < high
        _, low, high = disks.distribution()
        inside["band"] += low[60] < true.cdf(disks.factor[60]) < high[60]
    assert all(90 <= count < 100 for count in inside.values()), inside


@pytest.mark.oracle
def test_frequencies_of_blades_become_stiffnesses():
    """Of the blade of the lumped disk by itself, clamped at its root."""
    blade = np.array([[3e6, -2e6], [-2e6, 2e6]])
    deviation = np.array([0.04, -0.03, 0.0])
    squares = [scipy.linalg.eigvalsh((1.0 + d) * blade, np.diag(MASSES[1:]))[0] for d in deviation]
    found = rom.stiffness_deviation(np.sqrt(squares), np.sqrt(squares[2]))
    np.testing.assert_allclose(found, deviation, atol=1e-12)


@pytest.mark.oracle
def test_drawn_patterns_have_their_deviation():
    """48 000 numbers: the standard deviation of theirs is 0.3 % of it at most."""
    for uniform in (False, True):
        drawn = rom.random_mistuning(2000, 24, 0.04, uniform=uniform)
        assert abs(drawn.std() / 0.04 - 1.0) < 0.01
        assert np.array_equal(drawn, rom.random_mistuning(2000, 24, 0.04, uniform=uniform))
    assert np.abs(drawn).max() < 0.04 * np.sqrt(3.0)


def disks(law=LAW, deviation=DEVIATION):
    return rom.MistunedDisk(DISK, law, deviation, HIGHEST)


def factors(*given):
    return rom.Amplification(np.array(given), 1.0, 24)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: disks(deviation=np.zeros(11)), "deviation: must be 12 numbers between -1 and 1"),
        (lambda: disks(rom.Coulomb(1.0)), "law: mistuned disks need contacts that slide"),
        (lambda: disks().response([1200.0], ORDER, [1.0]), "amplitude} or 3 finite numbers"),
        (lambda: factors(1.1, 1.2).quantile(1.0), r"probability: must be between 0 and 1"),
        (lambda: factors(1.1, 1.3).extreme_value, r"^factor: .* at least 3 factors"),
        (lambda: rom.random_mistuning(9, 24, 0.5), "deviation: must be above 0 and at most 0.2"),
    ],
)
def test_wrong_disks_and_factors_are_refused(call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call()
