"""Limit cycles of one nodal diameter are those of all sectors by central differences."""

import numpy as np
import pytest
from cyclic.central_differences import between_sectors, frequency_of, march, modal
from cyclic.fluttering_disk import fluttering_disk

from benchmarks.slow_case import amplitudes, constant_inputs
from slipmode import rom
from slipmode.fmu import Component

SECTORS = 6
STEP = 1e-5


def motion_of(disk, state, nodal_diameter):
    """Displacement and velocity of all sectors in a wave, (2, n_s N)."""
    c = 2.0 * disk.around(state.displacement, nodal_diameter)
    return np.array([c.real, (1j * state.frequency * c).real])


@pytest.mark.parametrize(
    # Measured: amplitude 7e-6, 2e-6, 3e-5; frequency 7e-6, 8e-6, 1e-5, by the steps of full order.
    ("own", "stiffness", "nodal_diameter"),
    [
        (-3e3j, 5e4, -1),
        pytest.param(-3e3j, 5e4, 2, marks=pytest.mark.slow),
        pytest.param(-1.2e4j, 2e5, -2, marks=pytest.mark.slow),
    ],
)
def test_limit_cycles_are_those_of_all_sectors(own, stiffness, nodal_diameter):
    disk, fluttering = fluttering_disk(SECTORS, own)
    law = rom.Jenkins(1.0, stiffness)
    wave = rom.travelling_wave(fluttering, law, nodal_diameter)
    state, unstable = wave.limit_cycles()
    assert abs(state.amplitude) < abs(unstable.amplitude)
    times, motion = march(
        disk.annulus(),
        law,
        duration=1.0,
        step=STEP,
        last=0.2,
        between=between_sectors(fluttering),
        start=1.02 * motion_of(disk, state, nodal_diameter),
    )
    in_wave = modal(disk, wave, motion)
    frequency, amplitude = frequency_of(times, in_wave)
    found = abs(modal(disk, wave, disk.around(state.displacement, nodal_diameter)))
    assert abs(found / amplitude - 1.0) < 1e-4
    assert abs(state.frequency / frequency - 1.0) < 5e-5


def test_a_component_grows_to_the_limit_cycle():
    disk, fluttering = fluttering_disk(SECTORS, -6e3j)
    law, k = rom.Jenkins(1.0, 2e4), -1
    wave = rom.travelling_wave(fluttering, law, k)
    cycle, _ = wave.limit_cycles()
    size, omega, cycles = abs(cycle.amplitude), cycle.frequency, 200
    component = Component(wave.tabulate(2.0 * size, None, frequency=omega), [{}])
    component.reset(amplitude=[0.5 * size])
    period = 2.0 * np.pi / omega
    inputs = constant_inputs(component, (omega,), cycles)
    run = amplitudes(component, component.run(np.full(cycles, period), inputs), 1)[:, 0]
    c = size * disk.around(wave.shape, k)
    span = {"duration": cycles * period, "step": STEP, "last": cycles * period}
    between, start = between_sectors(fluttering), [c.real, (1j * omega * c).real]
    times, motion = march(disk.annulus(), law, between=between, start=start, **span)
    expected = np.abs(modal(disk, wave, motion))
    found = np.interp(times / period, np.arange(cycles + 1), np.abs([0.5 * size, *run]))
    off = np.sqrt(np.mean((found / expected - 1.0) ** 2))
    assert off < 4e-3  # measured 0.0025
    assert expected[-1] > 1.9 * expected[0]


def test_a_wave_that_is_not_self_excited_has_no_limit_cycle():
    _, fluttering = fluttering_disk(SECTORS)
    wave = rom.travelling_wave(fluttering, rom.Jenkins(1.0, 5e4), 1)
    with pytest.raises(rom.SlipmodeError, match="aerodynamics: mode 0 of nodal diameter 1 is not"):
        wave.limit_cycles()
