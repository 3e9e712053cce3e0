"""Aerodynamic coefficients of modes, against the matrices of a structure that has them."""

import numpy as np
import pytest
import scipy.sparse
from elastic.cantilever import LAWS, cantilever

from slipmode import rom
from slipmode.rom import full

COEFFICIENTS = (0.03 - 0.05j, -0.1 + 0.02j)
LAW = rom.Jenkins(1e6, LAWS["Jenkins"].stiffness)


@pytest.mark.oracle
@pytest.mark.parametrize("elastic", [False, True], ids=["bonded", "stuck"])
def test_modes_have_the_stiffness_and_damping_of_their_forces(elastic):
    structure, law = (cantilever(LAW), LAW) if elastic else (rom.two_mass(beta=0.01), None)
    alone = rom.reduce(structure, law=law)
    given = rom.reduce(structure, law=law, aerodynamics=COEFFICIENTS)
    c, omega = np.array(COEFFICIENTS), alone.frequency
    np.testing.assert_allclose(given.frequency, np.sqrt(omega**2 + c.real), rtol=1e-14)
    np.testing.assert_allclose(given.structural_frequency, omega, rtol=1e-14)
    np.testing.assert_allclose(given.modal_damping, alone.modal_damping + c.imag / omega)
    forced = full.aeroelastic(structure, given)
    along = np.asarray(structure.mass) @ alone.mode_shapes
    np.testing.assert_allclose(
        forced.stiffness - structure.stiffness, (along * c.real) @ along.T, atol=1e-11
    )
    np.testing.assert_allclose(
        forced.damping - structure.damping, (along * c.imag / omega) @ along.T, atol=1e-12
    )
    assert full.aeroelastic(structure, alone) is structure


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:friction does not act")
def test_stuck_contacts_leave_the_linear_response_under_these_forces():
    """(K + i nu C - nu^2 M) x = f, with the aerodynamic forces in K and C."""
    structure = cantilever(LAW)
    c = np.array([2.0 + 0.3j])
    reduced = rom.reduce(structure, (0,), law=LAW, aerodynamics=c)
    nu, omega = 0.99 * reduced.frequency[0], reduced.structural_frequency[0]
    found = rom.steady_state(reduced, LAW, [nu], [{7: 1.0}])
    W, along = np.asarray(structure.directions), structure.mass @ reduced.mode_shapes
    K = structure.stiffness + (W * LAW.stiffness) @ W.T + 2.0 * along @ along.T
    C = structure.damping + 0.3 / omega * along @ along.T
    x = np.linalg.solve(K + 1j * nu * C - nu**2 * structure.mass, np.eye(24)[7])
    moved = [found.displacement(dof)[0] for dof in range(24)]
    np.testing.assert_allclose(moved, np.abs(x), atol=1e-5 * np.abs(x).max())


def test_sparse_structures_have_the_aerodynamics_of_dense_ones():
    dense = rom.two_mass(beta=0.01)
    store = scipy.sparse.csc_array
    structure = rom.Structure(store(dense.mass), store(dense.stiffness), 0.01, contact=(2, 3))
    pair = [(each, rom.reduce(each, aerodynamics=COEFFICIENTS)) for each in (structure, dense)]
    np.testing.assert_allclose(*(reduced.modal_damping for _, reduced in pair))
    np.testing.assert_allclose(*(full.aeroelastic(*each).damping for each in pair), atol=1e-15)
