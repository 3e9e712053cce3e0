"""Contacts that are soft against the modes that respond to them: solved, or refused with why."""

import numpy as np
import pytest
from beside_oracle import steady_amplitudes, system_of
from elastic.blade import blade

from slipmode import rom

pytestmark = pytest.mark.quick


def softened(factor):
    return rom.two_mass(k_c1=20 / factor, k_c2=40 / factor, k_p=5 / factor)


@pytest.mark.oracle
@pytest.mark.parametrize("factor", [15.0, 22.0])
def test_the_warning_states_the_share_of_stiffness_that_modes_take_away(factor):
    """At the largest harmonic, of all stiffness of a contact, from the matrices."""
    structure, frequency = softened(factor), np.array([0.98, 1.65])
    M, K, W = structure.mass, structure.stiffness, structure.directions
    C = np.asarray(structure.damping)
    shares = []
    for n in range(6):
        for m in range(-5, 6):
            if (n + abs(m)) % 2 == 0 or n + abs(m) > 5 or (n == 0 and m < 0):
                continue
            nu = frequency @ [n, m]
            # a mode does not respond at its own carrier, which has its slow flow
            held = [(n, m) == (1, 0), (n, m) == (0, 1)]
            basis = np.eye(4)[:, ~np.array([*held, False, False])]
            D = basis.T @ (K + 1j * nu * C - nu**2 * M) @ basis
            Z = np.linalg.inv(W.T @ basis @ np.linalg.solve(D, basis.T @ W))
            own = K[2:, 2:]  # contacts on modes that are fixed
            inert = own + 1j * nu * C[2:, 2:] - nu**2 * M[2:, 2:]
            lost = np.linalg.eigvals(np.linalg.solve(own, (inert - Z).real)).real.max()
            shares.append(lost)
    assert 0.5 < max(shares) < 1.0
    with pytest.warns(rom.ValidityWarning, match="contact stiffness is low") as issued:
        rom.tabulate(rom.reduce(structure, carrier=frequency), rom.Tanh(2.0, 0.02), (0.01, 0.01),
                     tolerance=0.1)  # fmt: skip
    (low,) = [str(each.message) for each in issued if "stiffness is low" in str(each.message)]
    stated = float(low.split("reduces the contact stiffness by ")[1].split(" %")[0])
    assert stated == pytest.approx(100.0 * max(shares), abs=1.0)  # of two digits


@pytest.mark.oracle
@pytest.mark.parametrize("factor", [15.0, 100.0])
def test_tables_of_soft_contacts_are_within_their_tolerance(factor):
    """Also where modes take away all the stiffness of contacts, and friction alone holds."""
    structure, law = softened(factor), rom.Tanh(2.0, 0.02)
    reduced = rom.reduce(structure, (0,), carrier=(0.98,))
    model = rom.tabulate(reduced, law, (1.2,), 5e-3, warned=False)
    found = rom.steady(model, (0.98,), ({0: 0.05},))
    expected, error = steady_amplitudes(
        system_of(structure, law), reduced, (0.98,), ({0: 0.05},), tolerance=1e-4, steps=256
    )
    assert abs(found - expected) <= 5e-3 * abs(expected) + error


@pytest.mark.filterwarnings("ignore:contact stiffness")
def test_a_response_that_does_not_settle_is_refused_with_mode_harmonic_and_what_would_help():
    """Two modes of a mesh that friction holds at a node; a third mode is near a third multiple."""
    M, K = (matrix[10:, 10:] for matrix in blade(14, 4))
    W = np.zeros((len(M), 1))
    W[2 * 53, 0] = 1.0
    bonded = rom.reduce(rom.Structure(M, K, 1e-3, contact=W))
    slipping = 3.0 / np.linalg.norm(bonded.spring, axis=1)
    refusal = (
        r"at 3.\d+ rad/s responds most, to harmonic \(0, 3\) at 3.\d+ rad/s; "
        "let contacts be elastic"
    )
    with pytest.raises(rom.SlipmodeError, match=refusal):
        rom.tabulate(bonded, rom.Coulomb(1.0), slipping, 1e-2)
