"""Forcing off the carriers of a friction table, with and without its slope."""

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
    answers = (
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
    for answer in answers:
        assert abs(answer - exact) < 5e-4 * abs(exact) + own
