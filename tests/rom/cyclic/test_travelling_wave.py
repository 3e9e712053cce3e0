"""A travelling wave from one sector equals the motion of all sectors, integrated independently."""

import numpy as np
import pytest
from cyclic.ring import SHROUD, TIPS, TWO, around, in_time, in_wave, ring, steady_wave

from slipmode import rom
from slipmode.fmu import Component

SECTORS = 8
CASES = {
    "weak": (TIPS, rom.Jenkins(1.0, 2e4)),
    "strong": (TIPS, rom.Jenkins(1.0, 2e5)),
    "ground": ({"contact": [[0.0], [0.0], [1.0]]}, rom.Jenkins(1.0, 2e5)),
    "two contacts": (TWO, rom.Jenkins((1.0, 0.6), (1e5, 3e4))),
    "sliders": (TIPS, rom.Sliders((0.3, 0.5, 1.0), (5e4, 3e4, 2e4))),
    "lift-off": (SHROUD, rom.FrictionalContact(0.3, 1.0, 5e4, 5e4)),
}
pytestmark = pytest.mark.oracle


def drawn(name, nodal_diameter=3):
    """The wave of a case, and the system of all sectors."""
    contacts, law = CASES[name]
    wave = rom.travelling_wave(rom.lumped_disk(SECTORS, 1e-5, **contacts), law, nodal_diameter)
    return wave, ring(SECTORS, law, contacts=contacts)


@pytest.mark.parametrize("nodal_diameter", [3, -2])
@pytest.mark.parametrize("name", CASES)
def test_steady_waves_are_those_of_all_sectors(name, nodal_diameter):
    wave, system = drawn(name, nodal_diameter)
    omega, force = 0.995 * wave.frequency, np.array([0.0, 3.0, 9.0j])
    (state,) = wave.steady_states(omega, force)
    expected, own = steady_wave(system, nodal_diameter, omega, force)
    size = np.abs(expected).max()
    off = np.abs(around(state.displacement, nodal_diameter, SECTORS) - expected).max()
    assert off <= 1e-4 * size + own  # as the tutorial of bladed disks says
    a = in_wave(wave.shape, nodal_diameter, expected)
    assert abs(state.amplitude - a) <= 1e-4 * abs(a) + own * abs(a) / size
    assert own < 3e-4 * size
    assert state.error <= 1e-3 * abs(state.amplitude)  # the tolerance


@pytest.mark.parametrize("off", [0.98, 1.005])
@pytest.mark.parametrize("name", ["weak", "strong", "two contacts"])
def test_curves_and_components_are_within_the_stated_error(name, off, tmp_path):
    """Also off the reference frequency of the table, which is the natural frequency."""
    wave, system = drawn(name)
    omega, force = off * wave.frequency, {2: 6.0}
    largest = abs(wave.steady_states(wave.frequency, force)[0].amplitude)
    wave.tabulate(2.0 * largest, force).save(tmp_path / "wave.npz")
    model = rom.Model.load(tmp_path / "wave.npz")
    curve = rom.response_curve(model, [omega], [force], "force", (0.9, 1.1), largest_step=0.01)
    c, own = steady_wave(system, 3, omega, [0.0, 0.0, 6.0])
    expected = abs(in_wave(wave.shape, 3, c))
    own /= np.abs(c).max()
    found, stated = (
        np.interp(1.0, curve.parameter, each[:, 0]) for each in (abs(curve.amplitude), curve.error)
    )
    assert abs(found - expected) <= stated + own * expected
    component = Component(model, [force], contact=True, elastic=[0, 1, 2])
    columns = [component.output_names.index(f"x_{dof}") for dof in range(3)]
    period = 2.0 * np.pi / omega
    steps = np.append(np.full(400, period), np.full(32, period / 32.0))
    given = {"force_A": 1.0, "frequency_A": omega, "limit_scale": 1.0}
    row = [given.get(name, 0.0) for name in component.input_names]
    x = component.run(steps, np.tile(row, (steps.size, 1)))[-32:, columns]
    of_component = 2.0 * np.abs(np.exp(-2j * np.pi * np.arange(32) / 32) @ x) / 32
    of_curve = [np.interp(1.0, curve.parameter, curve.displacement(dof)[:, 0]) for dof in range(3)]
    for x in (of_curve, of_component):
        assert np.abs(x / (2.0 * np.abs(c[:3])) - 1.0).max() <= stated / found + own


@pytest.mark.parametrize("stiffness", [2e4, 5e4])
def test_a_component_follows_the_wave_from_rest(stiffness):
    """Half the relative difference of stuck and free frequencies bounds the error.

    First-order averaging neglects changes of the amplitude within a period.
    """
    law, cycles, force = rom.Jenkins(1.0, stiffness), 200, {2: 6.0}
    disk = rom.lumped_disk(SECTORS, 1e-5)
    wave, free = (rom.travelling_wave(disk, each, 3) for each in (law, rom.Jenkins(1.0, 1e-3)))
    omega, period = wave.frequency, 2.0 * np.pi / wave.frequency
    (state,) = wave.steady_states(omega, force)
    component = Component(wave.tabulate(2.5 * abs(state.amplitude), force), [force])
    given = {"force_A": 1.0, "frequency_A": omega, "limit_scale": 1.0}
    row = [given.get(name, 0.0) for name in component.input_names]
    run = component.run(np.full(cycles, period), np.tile(row, (cycles, 1)))
    re, im = (run[:, component.output_names.index(f"A_{part}")] for part in ("re", "im"))
    motion = in_time(
        ring(SECTORS, law), cycles, omega, around([0.0, 0.0, 6.0], 3, SECTORS), samples=32
    )
    turned = in_wave(wave.shape, 3, motion.x) * np.exp(-1j * omega * motion.t)
    expected = np.abs(turned.reshape(cycles, 32).mean(axis=1))
    amplitude = np.abs(np.append(0.0, re + 1j * im))
    found = 0.5 * (amplitude[1:] + amplitude[:-1])
    off = np.sqrt(np.mean((found - expected) ** 2)) / expected.max()
    assert off < 0.5 * (wave.frequency / free.frequency - 1.0)  # measured 0.23, 0.25
