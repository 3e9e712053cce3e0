"""One sector by nodal diameter has the modes and contact motions of all sectors."""

import warnings

import numpy as np
import pytest
import scipy.linalg
from cyclic.ring import SHROUD, around, ring

from slipmode import rom

LAW = rom.Jenkins(1.0, 5e4)


def frequencies(K, M):
    return np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True))


@pytest.mark.oracle
def test_the_lumped_disk_has_the_published_frequencies():
    """Of pyHarm's tutorial, without contacts: 88.264, 169.344, 189.302 Hz."""
    diagram = rom.nodal_diameter_diagram(rom.lumped_disk(24), rom.Jenkins(1.0, 1e-3))
    columns = diagram.columns(rom.Units("Hz"))
    found = columns["frequency_0 [Hz]"][:3]
    np.testing.assert_allclose(found, [88.264, 169.344, 189.302], atol=6e-4)


@pytest.mark.oracle
@pytest.mark.parametrize("sectors", [3, 8])
def test_nodal_diameters_have_the_frequencies_of_all_sectors(sectors):
    """With stuck contacts. Diameters other than 0 and N / 2 occur forward and backward."""
    system = ring(sectors, LAW)
    diagram = rom.nodal_diameter_diagram(rom.lumped_disk(sectors, 1e-5), LAW)
    twice = [1 if k in (0, sectors / 2) else 2 for k in range(sectors // 2 + 1)]
    found = np.sort(np.repeat(diagram.frequency, twice, axis=0).ravel())
    np.testing.assert_allclose(found, frequencies(system.stuck(), system.M), rtol=1e-10)


@pytest.mark.oracle
def test_the_annulus_of_a_mistuned_disk_has_the_matrices_of_all_sectors():
    deviation = 0.04 * np.random.default_rng(3).standard_normal(7)
    whole = rom.lumped_disk(7, 1e-5, **SHROUD).annulus(deviation)
    expected = ring(7, rom.FrictionalContact(0.3, 1.0, 5e4, 5e4), 1e-5, 2e6, SHROUD, deviation)
    for found, of_ring in (
        (whole.mass, expected.M),
        (whole.damping, expected.C),
        (whole.stiffness, expected.K),
        (whole.directions, expected.W),
    ):
        np.testing.assert_allclose(found.toarray(), of_ring, atol=1e-9 * np.abs(of_ring).max())


@pytest.mark.oracle
@pytest.mark.parametrize("sectors", [12, 13])
def test_engine_orders_are_aliased_to_nodal_diameters(sectors):
    """An engine order and its nodal diameter load all sectors with the same phases."""
    for order in range(1, 3 * sectors):
        k = rom.excited_diameter(order, sectors)
        assert abs(k) <= sectors // 2
        np.testing.assert_allclose(
            around(1.0, order, sectors), around(1.0, k, sectors), atol=1e-12
        )


@pytest.mark.oracle
@pytest.mark.parametrize(("order", "diameter"), [(3, 3), (21, -3), (27, 3), (12, 12)])
def test_engine_orders_meet_the_modes_that_they_excite(order, diameter):
    diagram = rom.nodal_diameter_diagram(rom.lumped_disk(24), LAW)
    campbell = diagram.campbell((0.0, 1e5), [order])
    assert [each.mode for each in campbell.crossings] == [0, 1, 2]
    for each in campbell.crossings:
        omega = diagram.frequency[abs(diameter), each.mode]
        assert (each.nodal_diameter, each.frequency) == (diameter, omega)
        assert order * each.rotor_speed * 2.0 * np.pi / 60.0 == pytest.approx(omega)
    lowest = campbell.crossings[0].rotor_speed
    assert len(diagram.campbell((0.9 * lowest, 1.1 * lowest), [order]).crossings) == 1


@pytest.mark.parametrize("own", [1.0, -1.0])
def test_contacts_between_sectors_that_add_displacements_are_named(own):
    column = np.array([[0.0], [0.0], [own]])
    with warnings.catch_warnings(action="error"):
        rom.lumped_disk(24, contact=column)
        rom.lumped_disk(24, contact=column, next_contact=-column)
    with pytest.warns(rom.ValidityWarning, match="has the sign of contact at contact 0: .* give"):
        rom.lumped_disk(24, contact=column, next_contact=column)


def cyclic(**changed):
    given = {"sectors": 6, "contact": [1], "left": [0], "right": [2]} | changed
    return rom.CyclicStructure(np.diag([1.0, 1.0, 0.0]), np.diag([3.0, 2.0, 1.0]), **given)


def diagram(*given, speeds=(5.0, 10.0), orders=(3,)):
    return rom.nodal_diameter_diagram(rom.lumped_disk(24), LAW, *given).campbell(speeds, orders)


def wave(law=LAW, k=3, mode=0, disk=None):
    return rom.travelling_wave(disk or rom.lumped_disk(12), law, k, mode)


REFUSED = [
    (lambda: cyclic(sectors=2), "sectors: must be an integer >= 3, got 2"),
    (lambda: cyclic(left=[0, 1]), "left, right: must be as many DOFs on either side"),
    (lambda: diagram(speeds=(10.0, 5.0)), "rotor_speed: must be two numbers >= 0, ascend"),
    (lambda: wave(k=0, disk=rom.lumped_disk(6, ground_stiffness=0.0)), "has a rigid-body mode"),
    (lambda: wave(k=7), "nodal_diameter: must be an integer from -6 to 6 of 12 sectors"),
    (lambda: wave(rom.Coulomb(1.0)), "law: cyclic structures need elastic contacts"),
    (lambda: wave().steady_states(1e3, [0, 0, 0]), "force: does no work on mode 0 of nodal di"),
    (lambda: wave().limit_cycles(), "aerodynamics: mode 0 of nodal diameter 3 is not"),
]


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_wrong_structures_and_waves_are_refused_in_one_line(call, message):
    with pytest.raises(rom.SlipmodeError, match=message) as refusal:
        call()
    assert "\n" not in str(refusal.value)
