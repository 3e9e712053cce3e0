"""Sectors make the same structure as the annulus; sectors that do not fit are refused."""

import warnings

import numpy as np
import pytest
import scipy.linalg

from slipmode import rom
from slipmode.rom.cyclic.diameter_modes import AllDiameters


def hertz(mass, damping, stiffness):
    square = scipy.linalg.eigh(stiffness.toarray(), mass.toarray(), eigvals_only=True)
    return np.sqrt(square) / (2.0 * np.pi)


def test_the_lumped_disk_has_the_published_frequencies():
    """Of pyHarm's tutorial: 88.264, 169.344 twice, 189.302 Hz twice."""
    disk = rom.lumped_disk(24)
    found = [hertz(*disk.of_diameter(k))[0] for k in (0, 1, -1, 2, -2)]
    np.testing.assert_allclose(found, [88.264, 169.344, 169.344, 189.302, 189.302], atol=6e-4)


@pytest.mark.parametrize("sectors", [3, 8])
def test_nodal_diameters_have_the_frequencies_of_the_annulus(sectors):
    disk = rom.lumped_disk(sectors)
    whole = disk.annulus()
    assert whole.n_dofs == 3 * sectors
    assert whole.n_contacts == sectors
    diameters = range(sectors)
    by_sector = np.concatenate([hertz(*disk.of_diameter(k)) for k in diameters])
    together = hertz(whole.mass, whole.damping, whole.stiffness)
    np.testing.assert_allclose(np.sort(by_sector), together, rtol=1e-12)


def test_contacts_of_a_wave_move_as_those_of_the_annulus():
    disk, rng = rom.lumped_disk(7), np.random.default_rng(1)
    shape = rng.standard_normal(3) + 1j * rng.standard_normal(3)
    moved = disk.annulus().directions.T @ disk.around(shape, 2)
    expected = disk.around(disk.contact_motion(2) @ shape, 2)
    np.testing.assert_allclose(moved, expected, atol=1e-14)


def test_opposite_nodal_diameters_mirror_each_other():
    disk, springs = rom.lumped_disk(7), np.array([3e4])
    modes_of = AllDiameters(disk, springs, 1e5, {})
    forward = modes_of(2)
    assert modes_of(-2).frequency is forward.frequency  # not computed again
    direct = AllDiameters(disk, springs, 1e5, {})(-2)
    np.testing.assert_allclose(direct.frequency, forward.frequency, rtol=1e-12)
    for omega in (0.0, 2e3):
        np.testing.assert_allclose(
            modes_of(-2).flexibility(omega), direct.flexibility(omega), rtol=1e-9
        )


def test_the_static_response_is_that_of_the_whole_sector():
    disk, rng = rom.lumped_disk(7), np.random.default_rng(2)
    springs, k = np.array([3e4]), 2
    K, W = disk.of_diameter(k)[2].toarray(), disk.contact_motion(k).toarray()
    force = rng.standard_normal((3, 4)) + 1j * rng.standard_normal((3, 4))
    static = AllDiameters(disk, springs, 1e5, {})(k).static
    expected = np.linalg.solve(K + springs * W.conj().T @ W, force)
    np.testing.assert_allclose(static(force), expected, rtol=1e-10)


def test_sectors_that_float_are_refused():
    disk = rom.lumped_disk(6, ground_stiffness=0.0)
    with pytest.raises(rom.SlipmodeError, match="has a rigid-body mode"):
        rom.travelling_wave(disk, rom.Jenkins(1.0, 2e4), 0)


SECTOR = {
    "mass": np.diag([1.0, 1.0, 0.0]),
    "stiffness": np.diag([3.0, 2.0, 1.0]),
    "sectors": 6,
    "contact": [1],
    "left": [0],
    "right": [2],
}


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"sectors": 2}, "sectors: must be an integer >= 3, got 2"),
        ({"left": [0, 1]}, "left, right: must be as many DOFs on either side"),
        ({"left": [2]}, "left, right: .* 1 on both"),
        ({"right": [3]}, "right: DOFs must be 0 to 2"),
        ({"right": [2, 2]}, "right: must be different DOFs"),
        ({"left": [], "right": []}, "mass: every DOF must have mass"),
        ({"contact": np.ones((2, 1))}, "contact: must have 3 rows"),
        ({"next_contact": np.ones((3, 2))}, r"next_contact: must have shape \(3, 1\)"),
        ({"damping": -np.eye(3)}, "damping: must be positive semidefinite"),
    ],
)
def test_sectors_that_do_not_fit_are_refused_in_one_line(changed, message):
    with pytest.raises(rom.SlipmodeError, match=message) as refusal:
        rom.CyclicStructure(**(SECTOR | changed))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("sectors", [12, 13])
def test_engine_orders_are_aliased_to_nodal_diameters(sectors):
    """An engine order and its nodal diameter load all sectors with the same phases."""
    for order in range(1, 3 * sectors):
        k = rom.excited_diameter(order, sectors)
        assert abs(k) <= sectors // 2
        phases = np.exp(2j * np.pi * np.outer((order, k), np.arange(sectors)) / sectors)
        np.testing.assert_allclose(phases[0], phases[1], atol=1e-12)
    assert rom.excited_diameter(sectors + 3, sectors) == 3
    assert rom.excited_diameter(sectors - 3, sectors) == -3


@pytest.mark.parametrize("own", [1.0, -1.0])
def test_contacts_between_sectors_that_add_displacements_are_named(own):
    column = np.array([[0.0], [0.0], [own]])
    with warnings.catch_warnings(action="error"):
        rom.lumped_disk(24)
        rom.lumped_disk(24, contact=column)
        rom.lumped_disk(24, contact=column, next_contact=-column)
        rom.lumped_disk(24, contact=column, next_contact=[[0.0], [1.0], [-1.0]])
    with pytest.warns(rom.ValidityWarning, match="has the sign of contact at contact 0: .* give"):
        rom.lumped_disk(24, contact=column, next_contact=column)
