"""Aerodynamic forces by nodal diameter are those between all sectors."""

import numpy as np
import pytest
from cyclic.central_differences import between_sectors
from cyclic.fluttering_disk import fluttering_disk

from slipmode import rom
from slipmode.rom.structure.matrices import as_dense

SECTORS = 7
STUCK = rom.Jenkins(1.0, 5e4)


def stuck_matrices(disk, fluttering):
    """Mass, damping and stiffness of all sectors, with stuck contacts and aerodynamic forces."""
    whole = disk.annulus()
    W = as_dense(whole.directions)
    stiffness, damping = between_sectors(fluttering)
    K = as_dense(whole.stiffness) + STUCK.stiffness * W @ W.T + stiffness
    return as_dense(whole.mass), as_dense(whole.damping) + damping, K


def test_growth_rates_are_those_of_all_sectors():
    disk, fluttering = fluttering_disk(SECTORS)
    M, C, K = stuck_matrices(disk, fluttering)
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    expected = np.linalg.eigvals(A)
    families = [rom.flutter_growth(fluttering, STUCK, mode) for mode in range(3)]
    found = np.concatenate([each.growth + 1j * each.frequency for each in families])
    expected = expected[expected.imag > 0.0]
    apart = np.abs(found[:, np.newaxis] - expected).min(axis=1)
    assert np.all(apart < 1e-9 * np.abs(found))
    assert families[0].unstable == [-3, -2, 3, -1, 2, 0]
    assert not families[1].unstable


def test_stuck_waves_have_the_coupling_between_families():
    disk, fluttering = fluttering_disk(SECTORS)
    M, C, K = stuck_matrices(disk, fluttering)
    k, force = -2, np.array([0.0, 1e-6, 3e-6])
    wave = rom.travelling_wave(fluttering, STUCK, k, mode=1)
    omega = 1.01 * wave.frequency
    (state,) = wave.steady_states(omega, force)
    dynamic = K - omega**2 * M + 1j * omega * C
    expected = np.linalg.solve(dynamic, 0.5 * disk.around(force, k))
    np.testing.assert_allclose(disk.around(state.displacement, k), expected, rtol=1e-8)


def test_coefficients_of_nodal_diameters_are_those_of_the_distances():
    rng = np.random.default_rng(2)
    for sectors in (6, 7):
        diameters = range(-((sectors - 1) // 2), sectors // 2 + 1)
        c = {k: complex(*rng.standard_normal(2)) for k in diameters}
        influence = rom.influence_coefficients(c, sectors)
        for k, expected in c.items():
            turns = [l_d * np.exp(2j * np.pi * k * d / sectors) for d, l_d in influence.items()]
            assert abs(sum(turns) - expected) < 1e-12
    with pytest.raises(rom.SlipmodeError, match="by_diameter: must have each of the 7 nodal"):
        rom.influence_coefficients({0: 1.0, 7: 1j}, 7)


def test_modal_coefficients_change_frequency_and_damping_like_those_of_reduce():
    """c = 300 - 5e3 i rad^2/s^2 on the modes of one nodal diameter."""
    disk, c = rom.lumped_disk(SECTORS, 2e-6), 300.0 - 5e3j
    alone = rom.travelling_wave(disk, STUCK, 0)
    mass = disk.mass.toarray()
    D = (mass @ disk.expansion(0) @ alone.shape)[:, np.newaxis].real
    with_air = disk.with_aerodynamics(D, {0: c}, alone.frequency)
    wave = rom.travelling_wave(with_air, STUCK, 0)
    assert abs(wave.frequency**2 - alone.frequency**2 - c.real) < 1e-6
    added = [each.carrier(None, alone.frequency).damping for each in (wave, alone)]
    assert abs(added[0] - added[1] - c.imag / alone.frequency) < 1e-9


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"directions": [4]}, "directions: DOFs must be 0 to 3"),
        ({"influence": {7: 1.0}}, "influence: distances must be integers from -6 to 6, got 7"),
        ({"influence": {0: np.nan}}, "influence: must be a finite number, or 1 x 1 of them"),
        ({"influence": {0: np.ones((2, 2))}}, "influence: must be a finite number, or 1 x 1"),
        ({"frequency": 0.0}, "frequency: must be > 0 rad/s, got 0.0"),
    ],
)
def test_aerodynamic_forces_that_do_not_fit_are_refused(changed, message):
    given = {"directions": [2], "influence": {0: 1.0j}, "frequency": 1200.0} | changed
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.lumped_disk(SECTORS).with_aerodynamics(**given)


def test_what_does_not_include_aerodynamic_forces_refuses_them():
    _, fluttering = fluttering_disk(SECTORS)
    with pytest.raises(rom.SlipmodeError, match="aerodynamics: annulus does not include"):
        fluttering.annulus()
    with pytest.raises(rom.SlipmodeError, match="aerodynamics: MistunedDisk does not incl"):
        rom.MistunedDisk(fluttering, STUCK, np.zeros(SECTORS), 1e5)


def test_aerodynamic_forces_that_take_all_stiffness_are_refused():
    disk = rom.lumped_disk(SECTORS).with_aerodynamics([2], {0: -1e7}, 1200.0)
    with pytest.raises(rom.SlipmodeError, match="influence: the stiffness of mode 0"):
        rom.travelling_wave(disk, STUCK, 1)
