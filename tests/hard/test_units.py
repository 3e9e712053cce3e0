"""Hard cases: the same problem in other units has the same steady state, to rounding."""

import numpy as np
import pytest

from slipmode import rom

LENGTH, STIFFNESS, RATE = 1e-9, 1e8, 1e3  # [m], [N/m], [1/s]
MASS, FORCE = STIFFNESS / RATE**2, STIFFNESS * LENGTH
FREQUENCY, RANGE = np.array([0.98, 1.65]), np.array([4.0, 2.0])


def steady(structure, law, length, mass, rate):
    """Steady amplitudes in units of length times the root of mass."""
    unit = length * np.sqrt(mass)
    frequency = FREQUENCY * rate
    reduced = rom.reduce(structure, carrier=frequency.tolist())
    model = rom.tabulate(reduced, law, (unit * RANGE).tolist(), 1e-2)
    force = mass * rate**2 * length
    return rom.steady(model, frequency, ({0: 0.15 * force}, {1: 0.25 * force})) / unit


@pytest.mark.parametrize(
    ("law", "contact_mass"),
    [
        pytest.param(rom.Tanh(2.0, 0.02), 0.01, id="tanh", marks=pytest.mark.slow),
        pytest.param(rom.Coulomb(2.0), 0.01, id="Coulomb"),
        pytest.param(rom.Tanh(2.0, 0.02), 1e-6, id="mass ratio 1e-6", marks=pytest.mark.slow),
    ],
)
def test_units_of_a_small_stiff_structure(law, contact_mass):
    plain = rom.two_mass(beta=0.01, contact_mass=contact_mass)
    scaled = rom.Structure(
        MASS * np.asarray(plain.mass),
        STIFFNESS * np.asarray(plain.stiffness),
        0.01 / RATE,
        contact=(2, 3),
    )
    limit = 2.0 * FORCE
    other = rom.Coulomb(limit)
    if isinstance(law, rom.Tanh):
        other = rom.Tanh(limit, law.alpha * LENGTH * RATE)
    ours = steady(plain, law, 1.0, 1.0, 1.0)
    theirs = steady(scaled, other, LENGTH, MASS, RATE)
    assert np.abs(theirs / ours - 1.0).max() <= 1e-10
