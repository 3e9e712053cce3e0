"""Friction laws as values, and what they refuse."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import Contacts, Coulomb, FrictionalContact, Tanh


@pytest.mark.parametrize("law", [lambda limit: Tanh(limit, 0.1), Coulomb], ids=["tanh", "coulomb"])
@pytest.mark.parametrize("make", [tuple, list, np.array, lambda v: np.array(v, dtype=np.float32)])
def test_laws_compare_and_hash_by_value(law, make):
    limits = make([2.0, 0.5])
    one, same, other = law(limits), law((2.0, 0.5)), law(make([2.0, 0.25]))
    assert (one, hash(one)) == (same, hash(same))
    assert one != other
    if isinstance(limits, np.ndarray):
        limits[:] = 7.0
        assert one == same
    assert Coulomb(np.float64(2.0)) == Coulomb(2) != Coulomb((2.0,))
    assert Tanh(2.0, 0.1) != Coulomb(2.0)


E = np.eye(6)
SURFACE = FrictionalContact(0.3, 1.0, 20.0, 30.0)
OPEN = FrictionalContact(0.3, 0.0, 20.0, 30.0, gap=0.1)


def surface(**values):
    given = {"mu": 0.3, "preload": 1.0, "tangential_stiffness": 2.0, "normal_stiffness": 3.0}
    return lambda: FrictionalContact(**(given | values))


def reduced(law, W):
    n = len(W)
    return rom.reduce(rom.Structure(np.eye(n), np.eye(n) + 0.1, 0.01, contact=W), (0,), law=law)


def on(law, W):
    return lambda: reduced(law, W)


REFUSED = [
    (surface(mu=(0.1, -0.1)), "mu: must be 0 or 1e-30 to 1e+30 [-], got (0.1, -0.1)"),
    (surface(normal_stiffness=0.0), "normal_stiffness: must be 1e-30 to 1e+30 [N/m], got 0.0"),
    (surface(gap=(0.0, 0.1)), "gap: must be 0 where preload > 0, because the contact is closed"),
    (lambda: rom.Iwan(2.0, 20.0, chi=1.01, beta=0.3), "chi: must be above -1 and at most 1, got"),
    (on(SURFACE, E[:, :3]), "contact: a frictional contact has 2 DOFs (1 tangential, 1 normal)"),
    (on(SURFACE, E[:, [0, 1, 2, 1]]), "independent; 1 and 3 are the same"),
    (on(Contacts([(SURFACE, (0, 1)), (SURFACE, (2, 1))]), E[:, :3]), "contacts: every contact DO"),
    (on(FrictionalContact((0.1, 0.2, 0.3), 1, 1, 1), E[:, :4]), "mu: must be one number or 2 num"),
    (on(OPEN, E[:, :4]), "gap: all contacts are open at rest, and at least one must touch; reduc"),
    (on(Coulomb(1.0), E[:, :4]), "law: must be an elastic law; leave it out for rigid friction"),
    (lambda: Contacts([(Coulomb(1.0), (0,)), (SURFACE, (1, 2))]), "groups must have elastic laws"),
]


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_refuses_in_one_line(call, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        call()
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def rotated(angle):
    """Tangent and normal of a node's translations, turned."""
    c, s = np.cos(angle), np.sin(angle)
    return np.vstack((np.array([[c, -s], [s, c]]), np.zeros((2, 2))))


def test_directions_of_a_contact_are_a_frame_in_any_coordinates(recwarn):
    """Turned, weighted by an area, interpolated between nodes, modal; others are warned of."""
    turned = rotated(0.6)
    modal = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0] * [1.0, 2.0, 3.0, 4.0]
    between = 0.3 * turned + 0.7 * np.roll(turned, 2, axis=0)
    for W in (turned, 1e-4 * turned, between, modal.T @ turned):
        reduced(SURFACE, W)
    assert not recwarn.list
    for skewed, message in (
        (turned @ [[1.0, 0.5], [0.0, 1.0]], "0 and 1 are at 63 degrees"),
        (turned @ [[1.0, 0.0], [0.0, 2.0]], "0 and 1 are 1 and 2 long"),
    ):
        with pytest.warns(rom.ValidityWarning, match=f"contacts: contact DOFs {message} "):
            reduced(SURFACE, skewed)


# Friction in two directions, as a return map: paths in closed form


def path(x, tangents, preload):
    law = FrictionalContact(0.5, preload, 3.0, 2.0, tangents=tangents)
    return law.elements(tangents + 1).march(np.array(x))[0]


@pytest.mark.oracle
@pytest.mark.parametrize("steps", [1, 64])
def test_a_contact_dragged_along_a_line_turns_as_the_string_of_a_tractrix(steps):
    """After a way s its angle is 2 atan(tan(theta / 2) exp(-s / rho)), rho = mu N / k_t."""
    N, along, angle = 1.2, 0.7, 1.2
    start = 4.0 * np.array([np.cos(angle + along), np.sin(angle + along), 0.0])
    way = np.linspace(0.0, 0.5, steps + 1)[:, np.newaxis]
    force = path(start + way * [np.cos(along), np.sin(along), 0.0], 2, N)
    after = along + 2.0 * np.arctan(np.tan(0.5 * angle) * np.exp(-0.5 * 3.0 / (0.5 * N)))
    for at, expected in ((force[0], angle + along), (force[-1], after)):
        np.testing.assert_allclose(at[:2], 0.6 * np.array([np.cos(expected), np.sin(expected)]))


@pytest.mark.oracle
@pytest.mark.parametrize("tangents", [1, 2])
def test_a_contact_begins_to_stick_where_it_touches_down(tangents):
    """After three quarters of the step."""
    x = np.zeros((2, tangents + 1))
    x[:, 0], x[:, -1] = (1.0, 1.04), (-0.3, 0.1)
    opened, closed = path(x, tangents, 0.0)
    np.testing.assert_array_equal(opened, 0.0)
    np.testing.assert_allclose(closed[[0, -1]], (3.0 * 0.01, 2.0 * 0.1))
