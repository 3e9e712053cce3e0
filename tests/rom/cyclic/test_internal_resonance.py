"""Harmonics of the contacts that come close to a mode are named, and included where asked for."""

import warnings

import numpy as np
import pytest
from cyclic.ring import ring, steady_wave
from oracles.harmonic_balance import contact_forces, to_complex
from oracles.system import System, jenkins

from slipmode import rom

SECTORS, ORDER = 12, 3
FORCE = [0.0, 0.0, 6.0]
DEVIATION = 0.04 * np.random.default_rng(3).standard_normal(SECTORS)
STRONG = rom.Jenkins(1.0, 2e5)


def mistuned(tip, stiffness, limit):
    disk = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, tip))
    law = rom.Jenkins(limit, stiffness)
    omega = 0.97 * rom.travelling_wave(disk, law, ORDER).frequency
    return law, omega, rom.MistunedDisk(disk, law, DEVIATION, highest=1e5)


@pytest.mark.slow
@pytest.mark.oracle
def test_an_internal_resonance_is_named_and_included():
    law, omega, disks = mistuned(2.5e6, 2e5, 4.0)
    system = ring(SECTORS, law, 1e-5, 2.5e6, deviation=DEVIATION)
    expected, own = steady_wave(system, ORDER, omega, FORCE)
    message = (
        r"internal resonance 1:3 is neglected by local contacts: 3 x 1469.4 rad/s is close to "
        r"nodal diameter 3 of family 1, 4390.1 rad/s with stuck contacts.*without local "
        "includes the resonance"
    )
    with pytest.warns(rom.ValidityWarning, match=message):
        local = disks.response(omega, ORDER, FORCE, local=True).displacement[0, 0, :, 2]
    with warnings.catch_warnings(action="error"):
        exact = disks.response(omega, ORDER, FORCE).displacement[0, 0, :, 2]
    with pytest.warns(rom.ValidityWarning, match="internal resonance 1:3"):
        disks.transient([0.0, 0.01], omega, ORDER, FORCE)
    own /= np.abs(expected).max()
    assert np.abs(local / expected[2::3] - 1.0).max() > 0.05
    assert np.abs(exact / expected[2::3] - 1.0).max() < 1e-3 + own


@pytest.mark.oracle
def test_harmonics_of_a_contact_fall_with_the_square_of_their_order():
    """At most by 0.7 to 0.95 k |x| / h^2: the gain above which a resonance is named."""
    one, orders, found = np.eye(1), np.arange(3, 12, 2), []
    for size in np.geomspace(1.02, 60.0, 40):  # relative to the slip distance
        c = size * np.eye(1, 61, 1)
        force = contact_forces(System(one, one, one, one, [jenkins(1.0, 1.0)]), c)[0]
        found.append(np.abs(to_complex(force)[orders, 0]) / size)
    largest = np.max(found, axis=0) * orders**2
    assert 0.65 < largest.min() < largest.max() < 1.0


@pytest.mark.parametrize("beta", [1e-6, 1e-7])  # gains 3.5 and 35
def test_a_resonance_of_a_wave_that_does_not_converge_is_named(beta):
    disk = rom.lumped_disk(12, beta)
    at_6 = rom.nodal_diameter_diagram(disk, STRONG).frequency[6, 1]
    named = (
        r"does not become periodic. .* harmonic \(3, 0\) at 4094.8 rad/s excites mode 1 of nodal "
        "diameter 6 at 4094.8 rad/s"
    )
    with pytest.raises(rom.SlipmodeError, match=named):
        rom.travelling_wave(disk, STRONG, 2).steady_states(at_6 / 3.0, {2: 3.0})


@pytest.mark.parametrize(("k", "frequency", "warns"), [(2, 4094.8 / 3.0, True), (3, None, False)])
def test_a_table_near_a_resonance_warns(k, frequency, warns):
    """Gains 0.35 and 0.02: steady states converge, transients are not modelled."""
    wave = rom.travelling_wave(rom.lumped_disk(12, 1e-5), STRONG, k)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        wave.tabulate(1e-5, {2: 3.0}, 1e-2, frequency=frequency)
    text = " ".join(str(each.message) for each in caught)
    named = "contacts excite another mode: harmonic (3, 0)" in text
    assert (named and "mode 1 of nodal diameter 6" in text) is warns


def test_a_combination_of_two_waves_near_a_mode_is_named():
    """2 Omega_A - Omega_B acts on nodal diameter 2 2 - 3, backwards."""
    disk = rom.lumped_disk(12, 2e-5)
    waves = rom.travelling_wave(disk, STRONG, 2), rom.travelling_wave(disk, STRONG, 3, mode=1)
    with pytest.warns(
        rom.ValidityWarning, match=r"harmonic \(2, -1\) .* mode 0 of nodal diameter -1"
    ):
        rom.tabulate_waves(waves, (1e-6, 1e-6), ({2: 3.0}, {2: 3.0}), 0.1)
