"""Forcing off the carriers of a friction table: followed to first order, and stated beyond."""

import numpy as np
import pytest
from oracles.system import Coulomb, System, Tanh, Tone
from oracles.time_integration import steady_harmonics

from slipmode import rom

# Stiffness of contacts and between them, damping, law, its oracle, force, detuning of the force
FORCED = {
    "tanh": (
        {"k_c1": 40.0, "k_c2": 60.0, "k_p": 3.0, "beta": 0.01},
        *(rom.Tanh(2.0, 0.05), Tanh(2.0, 0.05), 0.15, -0.0175),
    ),
    "damped": (
        {"k_c1": 30.0, "k_c2": 50.0, "k_p": -5.0, "beta": 0.02},
        *(rom.Tanh(2.0, 0.05), Tanh(2.0, 0.05), 0.2, -0.02),
    ),
    "Coulomb": (
        {"k_c1": 80.0, "k_c2": 30.0, "k_p": 2.0, "beta": 0.015},
        *(rom.Coulomb(1.5), Coulomb(1.5), 0.1, -0.01),
    ),
}


def modal_force(reduced, structure, size):
    """A force on one retained mode alone."""
    return [F * structure.mass @ phi for F, phi in zip(size, reduced.mode_shapes.T, strict=True)]


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize("apart", [-0.05, 0.05])
@pytest.mark.parametrize("name", FORCED)
def test_one_mode_forced_off_the_carrier_moves_as_by_time_integration(name, apart):
    given, law, exact_law, size, detuned = FORCED[name]
    structure = rom.two_mass(**given)
    natural = rom.reduce(structure, (0,))
    Omega = natural.frequency * (1.0 + detuned)
    reduced = natural.at_carrier(Omega * (1.0 + apart))
    force = modal_force(reduced, structure, [size])
    followed, plain = (
        rom.steady(rom.tabulate(reduced, law, (5.0,), 1e-4, detuning=detuning), Omega, force)[0]
        for detuning in (True, False)
    )
    matrices = structure.mass, structure.damping, structure.stiffness, structure.directions
    system = System(*map(np.asarray, matrices), [exact_law] * 2)
    steps = 4096 if name == "Coulomb" else 1024
    found = steady_harmonics(system, [Tone(Omega[0], force[0])], [[1]], steps=steps)
    row = 0.5 * reduced.mode_shapes[:, 0] @ system.M
    exact, own = row @ found.amplitude[0], np.abs(row) @ found.error[0]
    assert own < 1e-3 * abs(exact)
    assert abs(followed - exact) < 5e-4 * abs(exact) + own
    if name == "damped":
        assert abs(plain - exact) > 2e-3 * abs(exact)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_a_linear_structure_is_followed_with_an_error_of_second_order():
    """Two modes; slow contacts of tanh friction are dashpots."""
    structure, c = rom.two_mass(beta=0.05), 10.0
    reduced, law = rom.reduce(structure), rom.Tanh(1e3 * c, 1e3)
    model = rom.tabulate(reduced, law, (1.0, 1.0), 1e-4, detuning=True)
    W = structure.directions
    force = modal_force(reduced, structure, (0.01, 0.02))

    def error(distance):
        worst = 0.0
        for signs in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0)):
            Omega = reduced.carrier * (1.0 + distance * np.array(signs))
            found = rom.steady(model, Omega, force)
            for j, w in enumerate(Omega):
                Z = structure.stiffness - w**2 * structure.mass
                Z = Z + 1j * w * (structure.damping + c * W @ W.T)
                exact = 0.5 * force[j] @ np.linalg.solve(Z, force[j]) / (0.01, 0.02)[j]
                worst = max(worst, abs(found[j] / exact - 1.0))
        return worst

    coarse, fine = error(0.04), error(0.02)
    assert coarse < model.accuracy.detuning
    assert np.log2(coarse / fine) > 1.5  # 1 without dS / dOmega; the table itself adds 3e-5


@pytest.mark.quick
def test_the_error_of_forcing_off_the_carrier_is_stated_and_warned_of():
    natural = rom.reduce(rom.two_mass(beta=0.02), (0,))
    reduced = natural.at_carrier([1.000001 * natural.carrier[0]])
    law, force = rom.Tanh(2.0, 0.05), [{0: 0.15}]
    plain, followed = rom.tabulate(reduced, law, (4.0,)), rom.tabulate(natural, law, (4.0,))
    assert plain.table.detuning is None and followed.table.detuning is not None
    assert followed.accuracy.detuning < 0.3 * plain.accuracy.detuning
    with pytest.warns(rom.ValidityWarning, match="^frequency is up to 4 % away from the ref"):
        rom.steady(plain, 0.96 * reduced.carrier, force)
    rom.steady(followed, 0.96 * reduced.carrier, force)
    rom.steady(plain, 1.0 * reduced.carrier, force)
    alone = rom.tabulate(reduced, law, (4.0,), detuning=False)
    assert alone.accuracy.detuning is None
    with pytest.warns(rom.ValidityWarning, match="^frequency is up to 0.1 % .* not known. Tab"):
        rom.steady(alone, 0.999 * reduced.carrier, force)
