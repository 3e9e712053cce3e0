"""Friction laws as values, equal and of one hash where they are the same law; what they refuse."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import Contacts, Coulomb, FrictionalContact, Jenkins, Tanh


@pytest.mark.parametrize("law", [lambda limit: Tanh(limit, 0.1), Coulomb], ids=["tanh", "coulomb"])
@pytest.mark.parametrize("make", [tuple, list, np.array, lambda v: np.array(v, dtype=np.float32)])
def test_laws_compare_and_hash_by_value(law, make):
    one, same, other = law(make([2.0, 0.5])), law((2.0, 0.5)), law(make([2.0, 0.25]))
    assert one == same
    assert hash(one) == hash(same)
    assert one != other
    assert len({one, same, other}) == 2


@pytest.mark.parametrize("limit", [2, 2.0, np.float64(2.0), np.array(2.0), np.int64(2)])
def test_one_limit_is_a_number(limit):
    assert Coulomb(limit) == Coulomb(2.0)
    assert type(Coulomb(limit).limit) is float
    assert Coulomb(limit) != Coulomb((2.0,))


def test_a_law_keeps_its_limits_when_the_array_changes():
    limits = np.array([2.0, 0.5])
    law = Tanh(limits, np.float64(0.1))
    limits[:] = 7.0
    assert law == Tanh((2.0, 0.5), 0.1)
    assert Tanh(2.0, 0.1) != Coulomb(2.0)


SURFACE = FrictionalContact(0.3, 1.0, 20.0, 30.0)
PARAMETERS = [
    ({"mu": -0.1}, "mu: must be 0 or 1e-30 to 1e+30 [-], got -0.1"),
    ({"mu": (0.1, -0.1)}, "mu: must be 0 or 1e-30 to 1e+30 [-], got (0.1, -0.1)"),
    ({"mu": float("nan")}, "mu: must be 0 or 1e-30 to 1e+30 [-], got nan"),
    ({"preload": -1.0}, "preload: must be 0 or 1e-30 to 1e+30 [N], got -1.0"),
    ({"normal_stiffness": 0.0}, "normal_stiffness: must be 1e-30 to 1e+30 [N/m], got 0.0"),
    ({"tangential_stiffness": 0.0}, "tangential_stiffness: must be 1e-30 to 1e+30 [N/m], got 0."),
    ({"gap": -0.1}, "gap: must be 0 or 1e-30 to 1e+30 [m], got -0.1"),
    ({"gap": 0.1}, "gap: must be 0 where preload > 0, because the contact is closed"),
    ({"gap": (0.0, 0.1)}, "gap: must be 0 where preload > 0, because the contact is closed"),
    ({"preload": (0.0, 1.0), "gap": 0.1}, "gap: must be 0 where preload > 0, because "),
    ({"tangents": 3}, "tangents: must be 1 or 2, got 3"),
]


@pytest.mark.parametrize(("values", "message"), PARAMETERS)
def test_parameters_are_refused_in_one_line(values, message):
    given = {"mu": 0.3, "preload": 1.0, "tangential_stiffness": 2.0, "normal_stiffness": 3.0}
    with pytest.raises(rom.SlipmodeError) as refusal:
        FrictionalContact(**(given | values))
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)


def reduced(law, W):
    n = len(W)
    return rom.reduce(rom.Structure(np.eye(n), np.eye(n) + 0.1, 0.01, contact=W), (0,), law=law)


E = np.eye(6)
OPEN = FrictionalContact(0.3, 0.0, 20.0, 30.0, gap=0.1)
DIRECTIONS = [
    (SURFACE, E[:, :3], "contact: a frictional contact has 2 DOFs (1 tangential, 1 normal)"),
    (
        SURFACE,
        E[:, [0, 1, 2, 1]],
        "contact: directions (columns of W) must be linearly independen",
    ),
    (Contacts([(SURFACE, (0, 1)), (SURFACE, (2,))]), E[:, :4], "contacts: every contact DOF, 0 t"),
    (Contacts([(SURFACE, (0, 1)), (SURFACE, (2, 1))]), E[:, :3], "contacts: every contact DOF, 0"),
    (Contacts([(SURFACE, (0, 1, 2)), (Jenkins(1, 1), (3,))]), E[:, :4], "contact: a frictional c"),
    (FrictionalContact((0.1, 0.2, 0.3), 1, 1, 1), E[:, :4], "mu: must be one number or 2 number"),
    (FrictionalContact(0.1, (1, 0), 1, 1, gap=(0, 0, 1)), E[:, :4], "gap: must be one number or"),
    (
        OPEN,
        E[:, :4],
        "gap: all contacts are open at rest, and at least one must touch; reduce a g",
    ),
    (Contacts([(OPEN, (0, 1)), (OPEN, (2, 3))]), E[:, :4], "gap: all contacts are open at rest"),
    (Coulomb(1.0), E[:, :4], "law: must be an elastic law; leave it out for rigid friction"),
]


@pytest.mark.parametrize(("law", "W", "message"), DIRECTIONS)
def test_contacts_are_refused_in_one_line(law, W, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        reduced(law, W)
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)


def test_a_doubled_direction_is_named():
    with pytest.raises(rom.SlipmodeError, match="independent; 1 and 3 are the same"):
        reduced(SURFACE, np.eye(6)[:, [0, 1, 2, 1]])


def test_groups_are_of_elastic_laws():
    with pytest.raises(rom.SlipmodeError, match="contacts: groups must have elastic laws"):
        Contacts([(Coulomb(1.0), (0,)), (SURFACE, (1, 2))])


def rotated(angle):
    """Tangent and normal of a node's translations, turned."""
    c, s = np.cos(angle), np.sin(angle)
    return np.vstack((np.array([[c, -s], [s, c]]), np.zeros((2, 2))))


def test_directions_of_a_contact_are_a_frame(recwarn):
    """Turned, weighted by an area, interpolated between nodes: no warning."""
    turned = rotated(0.6)
    for W in (turned, 1e-4 * turned, 0.3 * turned + 0.7 * np.roll(turned, 2, axis=0)):
        reduced(SURFACE, W)
    assert not recwarn.list


def test_modal_coordinates_are_no_translations(recwarn):
    """Of a structure that comes reduced, every coordinate moves every contact."""
    shapes = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0] * [1.0, 2.0, 3.0, 4.0]
    reduced(SURFACE, shapes.T @ rotated(0.6))
    assert not recwarn.list


SKEWED = [
    (rotated(0.6) @ [[1.0, 0.5], [0.0, 1.0]], "0 and 1 are at 63 degrees"),
    (rotated(0.6) @ [[1.0, 0.0], [0.0, 2.0]], "0 and 1 are 1 and 2 long"),
]


@pytest.mark.parametrize(("W", "message"), SKEWED)
def test_warns_of_directions_that_are_no_frame(W, message):
    with pytest.warns(rom.ValidityWarning, match=f"contacts: contact DOFs {message} "):
        reduced(SURFACE, W)
