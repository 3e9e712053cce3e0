"""Disks whose blades differ: steady states of all sectors are those of full order."""

import numpy as np
import pytest
from cyclic.full_annulus import excitation, law_of_all

from slipmode import rom
from slipmode.rom import full

SECTORS, ORDER = 12, 3
FORCE = [0.0, 0.0, 6.0]
HIGHEST = 1e5  # all modes of the lumped disk
DEVIATION = 0.04 * np.random.default_rng(3).standard_normal(SECTORS)


def frequencies(disk, law):
    natural = rom.travelling_wave(disk, law, ORDER).frequency
    return natural * np.linspace(0.97, 0.995, 6)


def off(found, expected):
    """Largest difference of the blade tips, each relative to its own amplitude."""
    return np.abs(found / expected - 1.0)[..., 2].max()


@pytest.mark.filterwarnings("ignore:internal resonance")
@pytest.mark.parametrize(
    # Measured: 1.4e-5, 5e-5 and 1.6e-5, of which full order is up to 9e-5; with local contacts
    # 0.0087, 0.0143 and 0.0024. Stuck and free frequencies differ by 0.7, 1.7 and 6 %.
    ("stiffness", "with_local"),
    [(2e4, 0.01), pytest.param(5e4, 0.02, marks=pytest.mark.slow), (2e5, 0.005)],
)
def test_every_blade_moves_as_in_full_order(stiffness, with_local):
    disk, law = rom.lumped_disk(SECTORS, 1e-5), rom.Jenkins(1.0, stiffness)
    omega = frequencies(disk, law)
    mistuned = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST)
    exact, local = (
        mistuned.response(omega, ORDER, FORCE, local=each).displacement[0, -1]
        for each in (False, True)
    )
    structure = disk.annulus(DEVIATION)
    forced = excitation(disk, structure, ORDER, omega[-1], FORCE)
    outputs = range(structure.n_dofs)
    found = full.steady_amplitude(structure, law_of_all(disk, law), forced, outputs=outputs)
    expected = found.amplitude[0].reshape(SECTORS, 3)
    assert off(exact, expected) < 3e-4
    assert off(local, expected) < with_local


def test_two_contacts_a_sector():
    contacts = {
        "contact": [[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]],
        "next_contact": [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
    }
    disk, law = rom.lumped_disk(SECTORS, 1e-5, **contacts), rom.Jenkins((1.0, 0.6), (5e4, 3e4))
    omega = frequencies(disk, law)
    found = rom.MistunedDisk(disk, law, DEVIATION, HIGHEST).response(omega, ORDER, FORCE)
    structure = disk.annulus(DEVIATION)
    forced = excitation(disk, structure, ORDER, omega[-1], FORCE)
    law, outputs = law_of_all(disk, law), range(structure.n_dofs)
    expected = full.steady_amplitude(structure, law, forced, outputs=outputs).amplitude[0]
    assert off(found.displacement[0, -1], expected.reshape(SECTORS, 3)) < 3e-4


def test_a_tuned_disk_has_the_travelling_wave():
    disk, law = rom.lumped_disk(SECTORS, 1e-5), rom.Jenkins(1.0, 5e4)
    omega = frequencies(disk, law)
    found = rom.MistunedDisk(disk, law, np.zeros(SECTORS), HIGHEST).response(omega, ORDER, FORCE)
    wave = rom.travelling_wave(disk, law, ORDER)
    (state,) = wave.steady_states(omega[-1], FORCE, 1e-5)
    expected = disk.around(state.displacement, ORDER).reshape(SECTORS, 3)
    assert off(found.displacement[0, -1], expected) < 1e-4


@pytest.mark.filterwarnings("ignore:internal resonance")
def test_many_patterns_stay_below_whitehead_s_bound():
    """(1 + sqrt(N)) / 2 times the tuned amplitude, for linear disks; friction damps further."""
    N, rng = 24, np.random.default_rng(3)
    disk, law = rom.lumped_disk(N, 1e-5), rom.Jenkins(1.0, 5e4)
    omega = rom.travelling_wave(disk, law, ORDER).frequency * np.linspace(0.96, 1.02, 31)
    deviation = np.vstack((np.zeros(N), 0.04 * rng.standard_normal((20, N))))
    disks = rom.MistunedDisk(disk, law, deviation, HIGHEST)
    peak = disks.response(omega, ORDER, FORCE, local=True).peak(2)
    factor = peak[1:] / peak[0]
    assert factor.max() < 0.5 * (1.0 + np.sqrt(N))
    assert 1.2 < np.median(factor) < 1.5  # measured 1.33


def test_a_long_response_shows_its_progress(capfd):
    disk, law = rom.lumped_disk(24, 1e-5), rom.Jenkins(1.0, 2e4)
    disks = rom.MistunedDisk(disk, law, np.zeros(24), HIGHEST)
    near = rom.travelling_wave(disk, law, ORDER).frequency
    omega = near * np.linspace(0.97, 1.02, 60)
    disks.response(omega, ORDER, FORCE, progress=True)
    assert "60/60" in capfd.readouterr().err
    disks.response(omega[:2], ORDER, FORCE)
    assert not capfd.readouterr().err


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"deviation": np.zeros(11)}, "deviation: must be 12 numbers between -1 and 1"),
        ({"deviation": np.full(12, -1.0)}, "deviation: must be 12 numbers between -1 and 1"),
        ({"law": rom.Coulomb(1.0)}, "law: mistuned disks need contacts that slide"),
    ],
)
def test_disks_that_do_not_exist_are_refused(changed, message):
    disk = rom.lumped_disk(SECTORS)
    given = {"law": rom.Jenkins(1.0, 2e4), "deviation": np.zeros(SECTORS)} | changed
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.MistunedDisk(disk, given["law"], given["deviation"], HIGHEST)


def test_wrong_forces_and_frequencies_are_refused():
    disk = rom.MistunedDisk(
        rom.lumped_disk(SECTORS), rom.Jenkins(1.0, 2e4), np.zeros(SECTORS), HIGHEST
    )
    with pytest.raises(rom.SlipmodeError, match="amplitude} or 3 finite numbers"):
        disk.response([1200.0], ORDER, [1.0])
    with pytest.raises(rom.SlipmodeError, match="frequency: must be finite numbers > 0"):
        disk.response([0.0], ORDER, FORCE)
