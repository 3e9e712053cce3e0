"""Disks whose blades differ pass a resonance as in full order, and reach their steady states."""

import numpy as np
import pytest
from cyclic.swept_annulus import carriers, swept

from slipmode import rom

SECTORS, ORDER = 12, 3
HIGHEST = 1e5  # all modes of the lumped disk
DEVIATION = 0.02 * np.random.default_rng(3).standard_normal(SECTORS)


def lumped():
    # no mode near three times the frequency of the first family
    return rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6))


@pytest.mark.parametrize(
    # Measured: 0.0018, 0.0123, 0.0090 rms, of the worst blade 0.0034, 0.0148, 0.0099. The contacts
    # move up to 13, 5 and 2 times as far as they stick. Stuck and free frequencies of the highest
    # nodal diameter differ by 5 and 40 %.
    ("stiffness", "limit", "force", "span", "bound"),
    [
        (2e4, 1.0, 6.0, (0.96, 1.01), 0.004),
        (2e5, 4.0, 10.0, (0.93, 1.0), 0.015),
        (2e5, 10.0, 10.0, (0.96, 1.02), 0.011),
    ],
)
def test_a_sweep_through_resonance_is_that_of_full_order(stiffness, limit, force, span, bound):
    disk, law, f = lumped(), rom.Jenkins(limit, stiffness), [0.0, 0.0, force]
    omega = rom.travelling_wave(disk, law, ORDER).frequency * np.array(span)
    period, cycles = 2.0 * np.pi / omega[0], (200, 30)
    full_order = swept(disk, law, DEVIATION, ORDER, f, omega, cycles, dof=2)
    time = period * np.arange(0.0, sum(cycles) - 2, 4)
    frequency = np.interp(time, [0.0, period * cycles[0]], omega)
    found = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST).transient(time, frequency, ORDER, f)
    expected = carriers(*full_order, time[1:], period)
    off = np.abs(found.displacement[0, 1:, :, 2] - expected) ** 2
    rms = np.sqrt(off.mean(axis=0) / np.mean(np.abs(expected) ** 2, axis=0))
    assert np.sqrt(off.mean() / np.mean(np.abs(expected) ** 2)) < bound
    assert rms.max() < 1.2 * bound


@pytest.mark.parametrize(
    # Measured: 1.3e-6 and 2.0e-4 from the steady state with local contacts, and 2.7e-4 and 1.2e-3
    # from the one in which contacts act on each other at the higher harmonics
    ("stiffness", "limit", "bound", "exact"),
    [(2e4, 1.0, 1e-5, 4e-4), (2e5, 4.0, 4e-4, 2e-3)],
)
def test_the_end_is_the_steady_state(stiffness, limit, bound, exact):
    disk, law, f = lumped(), rom.Jenkins(limit, stiffness), [0.0, 0.0, 6.0]
    omega = 0.98 * rom.travelling_wave(disk, law, ORDER).frequency
    mistuned = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    end = mistuned.transient([0.0, 800 * np.pi / omega], omega, ORDER, f).displacement[0, -1]
    for local, most in ((True, bound), (False, exact)):
        steady = mistuned.response(omega, ORDER, f, local=local).displacement[0, 0]
        assert np.abs(end / steady - 1.0)[:, 2].max() < most


def test_the_end_is_the_steady_state_with_two_contacts_a_sector():
    contacts = {
        "contact": [[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]],
        "next_contact": [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
    }
    disk = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, 4e6), **contacts)
    law, f = rom.Jenkins((1.0, 0.6), (5e4, 3e4)), [0.0, 0.0, 6.0]
    omega = 0.98 * rom.travelling_wave(disk, law, ORDER).frequency
    mistuned = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    end = mistuned.transient([0.0, 800 * np.pi / omega], omega, ORDER, f).displacement[0, -1]
    steady = mistuned.response(omega, ORDER, f, local=True).displacement[0, 0]
    assert np.abs(end / steady - 1.0)[:, 2].max() < 1e-4  # measured 8e-6


@pytest.mark.parametrize(
    # Measured: 3.5e-4 and 1.6e-4 for weak joints, 1.9e-3 and 7.0e-3 for strong ones
    ("stiffness", "limit", "bound"),
    [(2e4, 1.0, 1e-3), (2e5, 4.0, 8e-3)],
)
@pytest.mark.filterwarnings("ignore:internal resonance")
def test_the_reference_frequency_matters_little(stiffness, limit, bound):
    disk, law, f = lumped(), rom.Jenkins(limit, stiffness), [0.0, 0.0, 6.0]
    omega = 0.98 * rom.travelling_wave(disk, law, ORDER).frequency
    mistuned = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    steady = mistuned.response(omega, ORDER, f, local=True).displacement[0, 0, :, 2]
    for reference in (omega / 1.099, 1.1 * omega):
        flow = mistuned.flow(reference, ORDER, f)
        flow.step(0.0, frequency=omega, magnitude=1.0)
        flow.step(800 * np.pi / omega)
        assert np.abs(flow.displacement()[:, 2] / steady - 1.0).max() < bound


def test_a_tuned_disk_without_slip_is_linear():
    """Free vibration after the force ends: each nodal diameter has its frequency and damping."""
    disk, law = lumped(), rom.Jenkins(1e3, 2e4)
    wave = rom.travelling_wave(disk, law, ORDER)
    flow = rom.MistunedDisk(disk, law, np.zeros(SECTORS), HIGHEST).flow(
        0.97 * wave.frequency, ORDER, {2: 1.0}
    )
    flow.step(0.0, magnitude=1.0)
    flow.step(0.5)
    flow.step(0.0, magnitude=0.0)
    before, duration = flow.displacement()[:, 2], 0.2
    flow.step(duration)
    M, C, K = (each.toarray() for each in disk.of_diameter(ORDER))
    W = disk.contact_motion(ORDER).toarray()
    K = K + 2e4 * W.conj().T @ W
    state = np.block(
        [[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]]
    )
    poles = np.linalg.eigvals(state)
    pole = poles[np.argmin(np.abs(poles - 1j * wave.frequency))]
    expected = before * np.exp((pole - 0.97j * wave.frequency) * duration)
    assert np.abs(flow.displacement()[:, 2] / expected - 1.0).max() < 1e-10  # measured 3e-12


def test_steps_do_not_change_the_motion():
    disk, law = lumped(), rom.Jenkins(4.0, 2e5)
    omega = 0.97 * rom.travelling_wave(disk, law, ORDER).frequency
    mistuned = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    ends = []
    for steps, tolerance in ((1, 1e-3), (40, 1e-3), (1, 1e-6)):
        flow = mistuned.flow(omega, ORDER, {2: 6.0}, tolerance=tolerance)
        for k in range(steps):
            part = (k + 1) / steps
            flow.step(0.3 / steps, frequency=omega * (1.0 + 0.02 * part), magnitude=part)
        ends.append(flow.displacement()[:, 2])
    once, often, exact = ends
    scale = np.abs(exact).max()
    assert np.abs(often - exact).max() < 1e-3 * scale  # measured 1.4e-4
    assert np.abs(once - exact).max() < 1e-3 * scale  # measured 4.6e-4


def test_patterns_are_followed_one_by_one():
    disk, law = lumped(), rom.Jenkins(1.0, 2e4)
    patterns = np.array([DEVIATION, -DEVIATION])
    time = np.linspace(0.0, 0.2, 3)
    both, alone = (
        rom.MistunedDisk(disk, law, each, HIGHEST).transient(time, 1190.0, ORDER, {2: 6.0})
        for each in (patterns, patterns[1])
    )
    assert both.displacement.shape == (2, 3, SECTORS, 3)
    off = np.abs(both.displacement[1] - alone.displacement[0]).max()
    assert off < 1e-3 * np.abs(alone.displacement).max()  # measured 5e-7


def test_wrong_inputs_are_refused_and_change_nothing():
    disk, law = lumped(), rom.Jenkins(1.0, 2e4)
    mistuned = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    flow = mistuned.flow(1200.0, ORDER, {2: 6.0})
    flow.step(0.01, magnitude=1.0)
    before = flow.displacement()
    for arguments, message in (
        ({"duration": -1.0}, "duration: must be a finite number >= 0, got -1.0"),
        (
            {"duration": 1.0, "frequency": 1500.0},
            "frequency = 1500 rad/s: must be within 10 % of 1200",
        ),
        ({"duration": 1.0, "magnitude": np.nan}, "magnitude: must be a finite number, got nan"),
    ):
        with pytest.raises(rom.SlipmodeError, match=message):
            flow.step(**arguments)
    assert np.array_equal(flow.displacement(), before)
    assert flow.time == 0.01
    for time, frequency, message in (
        ([1.0, 0.0], 1200.0, "time: must be increasing numbers"),
        ([0.0, 1.0], [1200.0], "frequency: must be a finite number or 2, one per time"),
        ([0.0, 1.0], -1.0, "frequency: must be > 0, got -1.0"),
    ):
        with pytest.raises(rom.SlipmodeError, match=message):
            mistuned.transient(time, frequency, ORDER, {2: 6.0})
    with pytest.raises(rom.SlipmodeError, match="pattern: must be 0 to 0, got 1"):
        mistuned.flow(1200.0, ORDER, {2: 6.0}, pattern=1)
    with pytest.raises(rom.SlipmodeError, match="tolerance: must be"):
        mistuned.flow(1200.0, ORDER, {2: 6.0}, tolerance=0.0)
