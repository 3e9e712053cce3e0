"""A harmonic near a mode of another nodal diameter is named."""

import warnings

import pytest

from slipmode import rom
from slipmode.rom.cyclic.wave.wave_problem import wave_contact_problem
from slipmode.rom.cyclic.wave.wave_resonances import strongest_resonance
from slipmode.rom.errors import UnsettledError

LAW = rom.Jenkins(1.0, 2e5)
FORCE = {2: 3.0}


def three_to_one(beta):
    """A wave of nodal diameter 2, and the third of the frequency of mode 1 at 6 of 12."""
    wave = rom.travelling_wave(rom.lumped_disk(12, beta), LAW, 2)
    return wave, float(wave.wave.modes_of(6).frequency[1]) / 3.0


@pytest.mark.parametrize("beta", [1e-6, 1e-7])  # gains 3.5 and 35
def test_a_resonance_that_does_not_converge_is_named(beta):
    wave, frequency = three_to_one(beta)
    named = (
        r"does not become periodic. .* harmonic \(3, 0\) at 4094.8 rad/s excites mode 1 of nodal "
        "diameter 6 at 4094.8 rad/s"
    )
    with pytest.raises(UnsettledError, match=named):
        wave.steady_states(frequency, FORCE)


def test_a_table_near_a_resonance_warns():
    """Gain 0.35 at beta = 1e-5: steady states converge, transients are not modelled."""
    wave, frequency = three_to_one(1e-5)
    (state,) = wave.steady_states(frequency, FORCE)
    named = r"contacts excite another mode: harmonic \(3, 0\) .* mode 1 of nodal diameter 6"
    with pytest.warns(rom.ValidityWarning, match=named):
        wave.tabulate(2.0 * abs(state.amplitude), FORCE, frequency=frequency)


def test_a_combination_of_two_waves_near_a_mode_is_found():
    """2 Omega_A - Omega_B acts on nodal diameter 2 2 - 3, backwards."""
    disk = rom.lumped_disk(12, 2e-5)
    waves = rom.travelling_wave(disk, LAW, 2), rom.travelling_wave(disk, LAW, 3, mode=1)
    carriers = [wave.carrier(FORCE, None) for wave in waves]
    met = strongest_resonance(carriers, wave_contact_problem(carriers, LAW))
    assert (met.order, met.nodal_diameter, met.mode) == ((2, -1), -1, 0)
    assert abs(met.frequency / met.natural_frequency - 1.0) < 0.005
    assert 0.3 < met.gain < 0.35


def test_waves_away_from_resonances_do_not_warn():
    disk = rom.lumped_disk(12, 1e-5)
    wave = rom.travelling_wave(disk, LAW, 3)  # gain 0.02
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wave.tabulate(1e-5, FORCE)
