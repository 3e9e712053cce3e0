"""Small added forces on contacts that slip."""

import numpy as np

from slipmode.rom.slow.nonresonant.response import _displacement_by

STIFFNESS = np.array([[21.0, 5.0], [5.0, 38.6]], dtype=complex)


def change(P, force, added):
    moved = _displacement_by(
        *(np.array([[each]], dtype=complex) for each in (added, STIFFNESS, P, force))
    )
    return moved[0, 0]


def test_a_contact_that_friction_alone_moves_keeps_its_motion():
    """Of a run with Coulomb friction: one contact sticks, no force acts on the other."""
    P, force = [0.0, 2.5e-8], [0.85, 0.0]
    np.testing.assert_array_equal(change(P, force, [0.01, 0.0]), [0.0, 0.0])


def test_a_slipping_contact_moves_in_proportion_to_its_force():
    P, force = [0.03, 0.0], [0.85, 0.1]
    np.testing.assert_allclose(change(P, force, [0.0085, 0.0]), [3e-4, 0.0], rtol=1e-12)
