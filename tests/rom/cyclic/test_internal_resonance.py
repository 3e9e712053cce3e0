"""Harmonics of the contacts that come close to a mode are named, and included where asked for."""

import warnings

import numpy as np
import pytest
from cyclic.full_annulus import excitation, law_of_all

from slipmode import rom
from slipmode.rom import full

SECTORS, ORDER = 12, 3
FORCE = [0.0, 0.0, 6.0]
DEVIATION = 0.04 * np.random.default_rng(3).standard_normal(SECTORS)


def mistuned(tip, stiffness, limit):
    disk = rom.lumped_disk(SECTORS, 1e-5, blade_stiffnesses=(1e6, tip))
    law = rom.Jenkins(limit, stiffness)
    omega = 0.97 * rom.travelling_wave(disk, law, ORDER).frequency
    return disk, law, omega, rom.MistunedDisk(disk, law, DEVIATION, highest=1e5)


def test_an_internal_resonance_is_named_and_included():
    disk, law, omega, disks = mistuned(2.5e6, 2e5, 4.0)
    structure = disk.annulus(DEVIATION)
    forced = excitation(disk, structure, ORDER, omega, FORCE)
    outputs = range(2, structure.n_dofs, 3)
    found = full.steady_amplitude(structure, law_of_all(disk, law), forced, outputs=outputs)
    message = (
        r"internal resonance 1:3 is neglected by local contacts: 3 x 1469.4 rad/s is close to "
        r"nodal diameter 3 of family 1, 4390.1 rad/s with stuck contacts.*without local "
        "includes the resonance"
    )
    with pytest.warns(rom.ValidityWarning, match=message):
        local = disks.response(omega, ORDER, FORCE, local=True).displacement[0, 0, :, 2]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        exact = disks.response(omega, ORDER, FORCE).displacement[0, 0, :, 2]
    assert np.abs(local / found.amplitude[0] - 1.0).max() > 0.05  # measured 0.11
    assert np.abs(exact / found.amplitude[0] - 1.0).max() < 1e-3  # measured 3.7e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    # Measured difference of local contacts: 0.001 to 0.005 without a warning, 0.016 to 0.02 with
    ("tip", "stiffness", "limit", "warns"),
    [
        (2e6, 2e4, 1.0, False),
        (2e6, 5e4, 1.0, True),
        (2.5e6, 5e4, 1.0, False),
        (2.5e6, 2e5, 1.0, True),
        (4e6, 2e5, 1.0, False),
        (4e6, 2e5, 4.0, False),
    ],
)
def test_the_warning_bounds_the_error_of_local_contacts(tip, stiffness, limit, warns):
    _, _, omega, disks = mistuned(tip, stiffness, limit)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        local = disks.response(omega, ORDER, FORCE, local=True).displacement[0, 0, :, 2]
    assert bool(caught) is warns
    exact = disks.response(omega, ORDER, FORCE).displacement[0, 0, :, 2]
    difference = np.abs(local / exact - 1.0).max()
    assert difference > 0.01 if warns else difference < 0.008


def test_harmonics_of_a_contact_fall_with_the_square_of_their_order():
    stiffness, samples, orders = 1.0, 1024, np.arange(3, 12, 2)
    phase = 2.0 * np.pi * np.arange(2 * samples) / samples
    size = np.geomspace(1.02, 60.0, 60)  # relative to that at which the contact slips
    x = size[:, np.newaxis] * np.cos(phase)
    force = np.zeros_like(x)
    for k in range(1, phase.size):
        force[:, k] = np.clip(force[:, k - 1] + stiffness * (x[:, k] - x[:, k - 1]), -1.0, 1.0)
    deficit = (stiffness * x - force)[:, samples:]  # once it is periodic
    harmonics = 2.0 * np.abs(np.fft.rfft(deficit)[:, orders]) / samples
    largest = (harmonics / size[:, np.newaxis]).max(axis=0) * orders**2
    # measured 0.95, 0.69, 0.74, 0.68, 0.70
    assert largest.min() > 0.65
    assert largest.max() < 1.0


def test_sweeps_name_it_too():
    _, _, omega, disks = mistuned(2.5e6, 2e5, 4.0)
    with pytest.warns(rom.ValidityWarning, match="internal resonance 1:3"):
        disks.transient([0.0, 0.01], omega, ORDER, FORCE)
