"""What holds whatever the amplitudes, structures, steps and units."""

import numpy as np
import pytest
from beside_oracle import amplitudes, run
from hypothesis import given, settings
from hypothesis import strategies as st

from slipmode import rom

pytestmark = pytest.mark.quick

few = settings(max_examples=10, derandomize=True, deadline=None)

GRID = rom.Discretisation(64, 8)
MARCH = 1e-5  # a march ends where harmonics repeat to this part of the frictionless motion
SPRINGS = {
    "k_c1": st.floats(10.0, 100.0),
    "k_c2": st.floats(20.0, 100.0),
    "k_p": st.floats(-8.0, 8.0),
    "contact_mass": st.floats(1e-4, 0.02),
    "beta": st.one_of(st.just(0.0), st.floats(1e-30, 0.02)),
}
FORCE_PATTERNS = ({0: 1.0}, {1: 1.0})
INPUTS = {"force_A": 0.15, "force_B": 0.25, "frequency_A": 0.98, "frequency_B": 1.65}


@given(
    order=st.permutations(range(4)),
    springs=st.fixed_dictionaries(SPRINGS),
    amplitude=st.tuples(st.floats(0.01, 5.0), st.floats(0.01, 5.0)),
)
@few
def test_the_numbers_of_the_dofs_and_the_sign_of_the_coupling_do_not_matter(
    order, springs, amplitude
):
    structure, law = rom.two_mass(**springs), rom.Tanh(2.0, 0.02)
    index = np.ix_(order, order)
    mass, stiffness = (np.asarray(m)[index] for m in (structure.mass, structure.stiffness))
    contact = [order.index(2), order.index(3)]
    renamed = rom.Structure(mass, stiffness, springs["beta"], contact=contact)
    turned = rom.two_mass(**springs | {"k_p": -springs["k_p"]})
    reduced = [rom.reduce(each) for each in (structure, renamed, turned)]
    Q, *others = (
        rom.ContactProblem.of(each, law).on(GRID, MARCH).solve([amplitude]).Q for each in reduced
    )
    flexibility = np.linalg.solve(reduced[0].stiffness, reduced[0].coupling.T)
    frictionless = np.abs(np.einsum("jc,cj->j", reduced[0].coupling, flexibility))
    for other in others:
        assert np.all(np.abs(other - Q) < 2 * MARCH * frictionless)


@pytest.fixture(scope="module")
def coulomb_model():
    return rom.tabulate(rom.reduce(rom.two_mass()), rom.Coulomb(2.0), (4.0, 4.0), 3e-2)


def march(model, durations, scale=1.0):
    """Return amplitudes after steps from rest, force and friction limit scaled together."""
    inputs = {k: scale * v if k.startswith("force") else v for k, v in INPUTS.items()}
    times = np.cumsum(durations)
    found = run(model, FORCE_PATTERNS, times, tolerance=1e-8, **inputs, limit_scale=scale)
    return amplitudes(found)[-1]


@pytest.mark.oracle
@given(scale=st.floats(1e-6, 1e6))
@few
def test_force_and_limit_scale_together_under_coulomb_friction(coulomb_model, scale):
    plain, scaled = march(coulomb_model, [200.0]), march(coulomb_model, [200.0], scale)
    np.testing.assert_allclose(scaled / scale, plain, rtol=1e-7)


@pytest.mark.oracle
def test_units_do_not_matter():
    """A small stiff structure, in units of length, mass and rate far from 1."""
    length, stiffness, rate = 1e-9, 1e8, 1e3
    mass, force = stiffness / rate**2, stiffness * length
    plain, found = rom.two_mass(beta=0.01), []
    matrices = mass * np.asarray(plain.mass), stiffness * np.asarray(plain.stiffness)
    scaled = rom.Structure(*matrices, 0.01 / rate, contact=(2, 3))
    for structure, law, L, m, r in (
        (plain, rom.Tanh(2.0, 0.02), 1.0, 1.0, 1.0),
        (scaled, rom.Tanh(2.0 * force, 0.02 * length * rate), length, mass, rate),
    ):
        unit, Omega, F = L * np.sqrt(m), 0.98 * r, 0.15 * m * r**2 * L
        reduced = rom.reduce(structure, (0,), carrier=(Omega,))
        model = rom.tabulate(reduced, law, (4.0 * unit,), 1e-2)
        found.append(rom.steady(model, (Omega,), ({0: F},)) / unit)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-10)
