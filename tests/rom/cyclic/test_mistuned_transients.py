"""Disks whose blades differ pass a resonance as all sectors do, and reach their steady states."""

import numpy as np
import pytest
from cyclic.ring import around, in_time, ring, steady_wave
from oracles.time_integration import state_matrix

from slipmode import rom

SECTORS, ORDER = 12, 3
HIGHEST = 1e5  # all modes of the lumped disk
DEVIATION = 0.02 * np.random.default_rng(3).standard_normal(SECTORS)
# no mode near three times the frequency of the first family
DISK = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6))
STRONG = rom.Jenkins(4.0, 2e5)


def system(law, deviation=DEVIATION):
    return ring(SECTORS, law, 1e-5, 4e6, deviation=deviation)


def near(law, part):
    return part * rom.travelling_wave(DISK, law, ORDER).frequency


@pytest.mark.oracle
@pytest.mark.parametrize(
    # Contacts move up to 13, 5 and 2 times as far as they stick.
    ("stiffness", "limit", "force", "span"),
    [
        pytest.param(2e4, 1.0, 6.0, (0.96, 1.01), marks=pytest.mark.slow),
        pytest.param(2e5, 4.0, 10.0, (0.93, 1.0), marks=pytest.mark.slow),
        (2e5, 10.0, 10.0, (0.96, 1.02)),
    ],
)
def test_a_sweep_through_resonance_is_that_of_all_sectors(stiffness, limit, force, span):
    """First-order averaging and local contacts: within a tenth of the relative difference of stuck
    and free frequencies, 2.3 and 21 %."""
    law, f = rom.Jenkins(limit, stiffness), np.array([0.0, 0.0, force])
    first, last = near(law, np.array(span))
    period, cycles = 2.0 * np.pi / first, 200
    end = period * cycles
    motion = in_time(
        *(system(law), cycles, first, around(f, ORDER, SECTORS)),
        phase=lambda t: first * t + 0.5 * (last - first) * t**2 / end,
    )
    angle = first * motion.t + 0.5 * (last - first) * motion.t**2 / end
    time = period * np.arange(0.0, cycles - 2, 4)
    expected = []
    for t in time[1:]:  # c changes linearly within a window; the third harmonic is fitted, too
        inside = np.abs(motion.t - t) <= period
        since, a, x = ((motion.t[inside] - t) / period, angle[inside], motion.x[inside, 2::3])
        columns = 2.0 * np.column_stack((np.cos(a), -np.sin(a), np.cos(3 * a), -np.sin(3 * a)))
        columns = np.hstack((columns, since[:, np.newaxis] * columns))
        fitted = np.linalg.lstsq(columns, x, rcond=None)[0]
        expected.append(fitted[0] + 1j * fitted[1])
    found = rom.MistunedDisk(DISK, law, DEVIATION, HIGHEST).transient(
        time, np.interp(time, [0.0, end], [first, last]), ORDER, f
    )
    off = np.abs(found.displacement[0, 1:, :, 2] - expected)
    stuck, free = (
        rom.travelling_wave(DISK, each, ORDER) for each in (law, rom.Jenkins(1.0, 1e-3))
    )
    relative = np.sqrt(np.mean(off**2) / np.mean(np.abs(expected) ** 2))
    assert relative < 0.1 * (stuck.frequency / free.frequency - 1.0)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:internal resonance")
@pytest.mark.parametrize(
    ("stiffness", "limit"), [(2e5, 4.0), pytest.param(2e4, 1.0, marks=pytest.mark.slow)]
)
def test_the_end_is_the_steady_state_of_all_sectors(stiffness, limit):
    """Contacts are local, 0.6 % at most, and another reference frequency changes less than 1 %."""
    law = rom.Jenkins(limit, stiffness)
    omega = near(law, 0.98)
    expected, own = steady_wave(system(law), ORDER, omega, [0.0, 0.0, 6.0])
    scale = np.abs(expected).max()
    disks = rom.MistunedDisk(DISK, law, DEVIATION, HIGHEST)
    local = disks.response(omega, ORDER, {2: 6.0}, local=True).displacement[0, 0]
    for reference, bound in ((omega, 1e-3), (omega / 1.099, 1e-2), (1.1 * omega, 1e-2)):
        flow = disks.flow(reference, ORDER, {2: 6.0})
        flow.step(0.0, frequency=omega, magnitude=1.0)
        flow.step(800.0 * np.pi / omega)
        found = flow.displacement()
        assert np.abs(found - local).max() < bound * scale
        assert np.abs(found.ravel() - expected).max() < (6e-3 + bound) * scale + own


@pytest.mark.oracle
def test_free_vibration_without_slip_has_the_pole_of_all_sectors():
    law = rom.Jenkins(1e3, 2e4)
    wave = rom.travelling_wave(DISK, law, ORDER)
    disks = rom.MistunedDisk(DISK, law, np.zeros(SECTORS), HIGHEST)
    flow = disks.flow(0.97 * wave.frequency, ORDER, {2: 1.0})
    flow.step(0.0, magnitude=1.0)
    flow.step(0.5)
    flow.step(0.0, magnitude=0.0)
    before, duration = flow.displacement()[:, 2], 0.2
    flow.step(duration)
    poles = np.linalg.eigvals(state_matrix(system(law, 0.0)))
    pole = poles[np.argmin(np.abs(poles - 1j * wave.frequency))]
    expected = before * np.exp((pole - 0.97j * wave.frequency) * duration)
    assert np.abs(flow.displacement()[:, 2] / expected - 1.0).max() < 1e-8


@pytest.mark.oracle
def test_errors_of_steps_are_within_their_tolerance():
    """Against a tolerance of 1e-6, also in many short steps."""
    omega = near(STRONG, 0.97)
    disks = rom.MistunedDisk(DISK, STRONG, DEVIATION, HIGHEST)
    ends = []
    for steps, tolerance in ((1, 1e-3), (40, 1e-3), (1, 1e-6)):
        flow = disks.flow(omega, ORDER, {2: 6.0}, tolerance=tolerance)
        for part in np.arange(1, steps + 1) / steps:
            flow.step(0.3 / steps, frequency=omega * (1.0 + 0.02 * part), magnitude=part)
        ends.append(flow.displacement()[:, 2])
    assert max(np.abs(e - ends[2]).max() for e in ends[:2]) < 1e-3 * np.abs(ends[2]).max()


@pytest.fixture(scope="module")
def disks():
    return rom.MistunedDisk(DISK, STRONG, DEVIATION, HIGHEST)


def test_refused_steps_change_nothing(disks):
    flow = disks.flow(1200.0, ORDER, {2: 6.0})
    flow.step(0.01, magnitude=1.0)
    before = flow.displacement()
    for given, message in (
        ({"duration": -1.0}, "duration: must be a finite number >= 0, got -1.0"),
        ({"duration": 1.0, "frequency": 1500.0}, "frequency = 1500 rad/s: must be within 10 %"),
        ({"duration": 1.0, "magnitude": np.nan}, "magnitude: must be a finite number, got nan"),
    ):
        with pytest.raises(rom.SlipmodeError, match=message):
            flow.step(**given)
    assert np.array_equal(flow.displacement(), before)
    assert flow.time == 0.01


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda d: d.transient([1, 0], 1e3, ORDER, {2: 1.0}), "time: must be increasing numbers"),
        (lambda d: d.transient([0, 1], [1e3], ORDER, {2: 1.0}), "frequency: .* 2, one per time"),
    ],
)
def test_wrong_inputs_are_refused(disks, call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(disks)
