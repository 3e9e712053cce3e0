"""Forcing off the carriers of a friction table, with and without its slope."""

import pytest
from beside_oracle import steady_amplitudes, system_of

from slipmode import rom

# k_c1, k_c2, k_p and beta of the structure, law, force, detuning of the force
FORCED = {
    "tanh": ((40.0, 60.0, 3.0, 0.01), rom.Tanh(2.0, 0.05), 0.15, -0.0175),
    "damped": ((30.0, 50.0, -5.0, 0.02), rom.Tanh(2.0, 0.05), 0.2, -0.02),
    "Coulomb": ((80.0, 30.0, 2.0, 0.015), rom.Coulomb(1.5), 0.1, -0.01),
}


def modal_force(reduced, structure, size):
    """A force on one retained mode alone."""
    return [F * structure.mass @ phi for F, phi in zip(size, reduced.mode_shapes.T, strict=True)]


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize("apart", [0.05, pytest.param(-0.05, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", FORCED)
def test_one_mode_forced_off_the_carrier_moves_as_by_time_integration(name, apart):
    given, law, size, detuned = FORCED[name]
    names = ("k_c1", "k_c2", "k_p", "beta")
    structure = rom.two_mass(**dict(zip(names, given, strict=True)))
    natural = rom.reduce(structure, (0,))
    Omega = natural.frequency * (1.0 + detuned)
    reduced = natural.at_carrier(Omega * (1.0 + apart))
    force = modal_force(reduced, structure, [size])
    answers = (
        rom.steady(rom.tabulate(reduced, law, (5.0,), 1e-4, detuning=detuning), Omega, force)[0]
        for detuning in (True, False)
    )
    steps = 4096 if name == "Coulomb" else 1024
    system = system_of(structure, law)
    exact, own = steady_amplitudes(system, reduced, Omega, force, steps=steps)
    assert own < 1e-3 * abs(exact)
    for answer in answers:
        assert abs(answer - exact) < 5e-4 * abs(exact) + own
