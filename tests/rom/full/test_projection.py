"""Full order on the coordinates of the reduced model."""

import numpy as np
import pytest
from elastic.frictional_beam import ROWS, TIP, structure

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.full.structures import Projection


@pytest.fixture(scope="module", params=["elastic", "rigid"])
def case(request):
    """A structure, its law, and its projection."""
    row = ROWS[4]
    elastic = request.param == "elastic"
    beam = structure(row.law, row.node if elastic else 2)
    law = row.law if elastic else rom.Coulomb(limit=0.2)
    reduced = rom.reduce(beam, (0,), law=law if elastic else None)
    force = np.zeros(beam.n_dofs)
    force[TIP] = 1.0
    return beam, law, reduced, force, Projection.of(beam, reduced, [force])


def test_it_is_small_and_orthonormal(case):
    beam, _, reduced, _, projection = case
    basis = projection.basis
    assert basis.shape[1] <= reduced.all_shapes.shape[1] + 2 < beam.n_dofs
    np.testing.assert_allclose(basis.T @ beam.mass @ basis, np.eye(basis.shape[1]), atol=1e-10)
    np.testing.assert_allclose(
        projection.to_coordinates @ basis, np.eye(basis.shape[1]), atol=1e-10
    )


def test_what_the_reduction_knows_is_exact(case):
    """Modes, and the static response to the force with stuck contacts."""
    beam, law, reduced, force, projection = case
    small = projection.structure
    if reduced.contacts is None:
        return
    k = law.stiffness
    held, W = beam.stiffness + k * beam.directions @ beam.directions.T, small.directions
    squares = np.linalg.eigvalsh(small.stiffness + k * W @ W.T)
    assert squares[0] == pytest.approx(reduced.frequency[0] ** 2, rel=1e-9)
    exact = np.linalg.solve(held, force)
    c = np.linalg.solve(small.stiffness + k * W @ W.T, projection.basis.T @ force)
    np.testing.assert_allclose(projection.basis @ c, exact, atol=1e-8 * np.abs(exact).max())


def test_it_moves_as_the_structure_does(case):
    beam, law, reduced, force, projection = case
    frequency = [0.99 * reduced.frequency[0]]
    times = np.linspace(0.05, 12.0, 240)
    signals = []
    for each, f, out in (
        (beam, force, force[np.newaxis]),
        (projection.structure, force @ projection.basis, (force @ projection.basis)[np.newaxis]),
    ):
        excitation = full.Excitation.harmonic(each, (0.05 * f,), frequency)
        motion = full.integrate(each, law, excitation, times, steps_per_period=64, outputs=out)
        signals.append(motion.displacement[:, 0])
    exact, found = signals
    assert np.linalg.norm(found - exact) < 4e-3 * np.linalg.norm(exact)
