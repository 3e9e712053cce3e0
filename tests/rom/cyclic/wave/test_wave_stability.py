"""Waves that break into others are found, and their pairs grow as those of all sectors."""

import numpy as np
from cyclic.central_differences import between_sectors, carriers, march, modal
from cyclic.fluttering_disk import fluttering_disk
from cyclic.full_annulus import excitation, law_of_all

from slipmode import rom
from slipmode.rom import full

# Tangential and normal motion of a shroud, both by the tips of neighbours.
SHROUD = {
    "contact": [[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]],
    "next_contact": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
}


def growth(times, amplitudes):
    return np.polyfit(times, np.log(amplitudes), 1)[0]


def test_a_wave_with_lift_off_breaks_into_another():
    disk, law, k = (
        rom.lumped_disk(12, 1e-5, **SHROUD),
        rom.FrictionalContact(0.3, 1.0, 2e5, 2e5),
        2,
    )
    wave, other = (rom.travelling_wave(disk, law, n) for n in (k, -4))
    omega, force = 0.985 * wave.frequency, [0.0, 10.0 / 3.0, 10.0j]
    (state,) = wave.steady_states(omega, force)
    size = abs(state.amplitude)
    assert not state.stable
    assert state.critical_pair.nodal_diameters == (-4, -4)
    structure, period, steps = disk.annulus(), 2.0 * np.pi / omega, 64
    c = disk.around(state.displacement, k) + disk.around(1e-3 * size * other.shape, -4)
    start = full.State(0.0, 2.0 * c.real, -2.0 * omega * c.imag)
    times = np.arange(64 * steps) * period / steps
    forced = excitation(disk, structure, k, omega, force)
    whole = law_of_all(disk, law)
    motion = full.integrate(structure, whole, forced, times, start=start).displacement
    turned = motion * np.exp(-1j * omega * times)[:, np.newaxis]
    in_time = turned.reshape(16, 4 * steps, -1).mean(axis=1)
    found, lost = (np.abs(modal(disk, each, in_time)) / size for each in (other, wave))
    # measured 24.70 and 24.7 1/s
    expected = growth(4.0 * period * np.arange(2, 8), found[2:8])
    assert abs(state.critical_pair.growth / expected - 1.0) < 0.02
    assert 0.4 < found[-1] < 0.5  # measured 0.46
    assert lost[-1] < 0.96


def test_a_limit_cycle_breaks_into_other_nodal_diameters():
    disk, fluttering = fluttering_disk(6, -1.2e4j)
    law, k = rom.Jenkins(1.0, 5e4), -1
    wave, other = (rom.travelling_wave(fluttering, law, n) for n in (k, 1))
    state, _ = wave.limit_cycles()
    assert not state.stable
    assert state.critical_pair.nodal_diameters == (1, 3)
    omega, size = state.frequency, abs(state.amplitude)
    c = disk.around(state.displacement, k) + disk.around(1e-3 * size * other.shape, 1)
    start = [2.0 * c.real, -2.0 * omega * c.imag]
    span = {"duration": 0.5, "step": 1e-5, "last": 0.5}
    between = between_sectors(fluttering)
    times, motion = march(disk.annulus(), law, between=between, start=start, **span)
    parts = np.array_split(np.arange(times.size), 10)[2:]
    in_time = [carriers(times[part], motion[part], [omega])[0] for part in parts]
    middle = [times[part].mean() for part in parts]
    expected = growth(middle, np.abs(modal(disk, other, np.array(in_time))))
    # measured 5.30 and 5.22 1/s
    assert abs(state.critical_pair.growth / expected - 1.0) < 0.03


def test_stuck_waves_leave_the_growth_of_flutter():
    _, fluttering = fluttering_disk(7)
    law = rom.Jenkins(1.0, 5e4)
    linear = rom.flutter_growth(fluttering, law)
    wave = rom.travelling_wave(fluttering, law, 1)
    (state,) = wave.steady_states(wave.frequency, {2: 1e-6})
    assert linear.unstable[0] in state.critical_pair.nodal_diameters
    assert abs(state.critical_pair.growth / linear.growth.max() - 1.0) < 1e-3  # measured 5e-4


def test_damped_waves_that_slip_are_stable():
    disk = rom.lumped_disk(12, 1e-5)
    wave = rom.travelling_wave(disk, rom.Jenkins(1.0, 5e4), 3)
    (state,) = wave.steady_states(0.995 * wave.frequency, {2: 9.0})
    assert state.stable
    # A pair decays as slowly as its own modes where contacts hardly hold.
    assert -20.0 < state.critical_pair.growth < -1.0
