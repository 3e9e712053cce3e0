"""What holds whatever the amplitudes, structures and steps: drawn, but the same every time."""

import numpy as np
import pytest
from beside_oracle import amplitudes, run
from hypothesis import given, settings
from hypothesis import strategies as st

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation

pytestmark = pytest.mark.quick

few = settings(max_examples=15, derandomize=True, deadline=None)

AMPLITUDES = st.tuples(st.floats(0.01, 5.0), st.floats(0.01, 5.0))
GRID = Discretisation(64, 8)
CARRIERS = ((1, 0), (0, 1))
MARCH = 1e-5  # a march ends where harmonics repeat to this part of the frictionless motion
SPRINGS = st.fixed_dictionaries(
    {
        "k_c1": st.floats(10.0, 100.0),
        "k_c2": st.floats(20.0, 100.0),
        "k_p": st.floats(-8.0, 8.0),
        "contact_mass": st.floats(1e-4, 0.02),
        "beta": st.one_of(st.just(0.0), st.floats(1e-30, 0.02)),
    }
)
LIMIT = st.one_of(st.just(0.0), st.floats(1e-30, 4.0))
LAWS = st.one_of(
    st.builds(rom.Tanh, st.tuples(LIMIT, LIMIT), st.floats(1e-6, 0.2)),
    st.builds(rom.Coulomb, st.tuples(LIMIT, LIMIT)),
)
FORCE_PATTERNS = ({0: 1.0}, {1: 1.0})
INPUTS = {"force_A": 0.15, "force_B": 0.25, "frequency_A": 0.98, "frequency_B": 1.65}


def frictionless(reduced):
    """|Q_j| without friction, (modes,)."""
    flexibility = np.linalg.solve(reduced.stiffness, reduced.coupling.T)
    return np.abs(np.einsum("jc,cj->j", reduced.coupling, flexibility))


def taken_by_dampers(structure, reduced, amplitude, terms):
    """Mean power in the structure's dampers as both modes are held at their amplitudes [W]."""
    power = 0.0
    for order, P in zip(terms.orders, terms.P[0], strict=True):
        nu = float(np.dot(order, reduced.carrier))
        B = reduced.modal_coupling(nu)
        if order in CARRIERS:
            held = CARRIERS.index(order)
            own = np.arange(len(reduced.modes)) == held
            q = reduced.response(nu, (-B @ P)[:, np.newaxis], own)[:, 0]
            q += amplitude[held] * reduced.response_by_dampers[held]
            q[held] = amplitude[held]
        else:
            q = -np.linalg.solve(reduced.modal_stiffness(nu), B @ P)
        v = nu * (reduced.all_shapes @ q + reduced.contact_shapes @ P)
        power += 2.0 * np.real(v.conj() @ structure.damping @ v)
    return power


def check_energy(structure, law, amplitude):
    """What holds the modes at their amplitudes goes into dampers and friction; the latter's share.

    Without a look at the contact forces: from S_j and from how all DOFs move. Harmonics that
    repeat to MARCH of the frictionless motion give S_j to MARCH of the frictionless one, and power
    is the sum of 2 Omega_j |a_j| Im S_j.
    """
    reduced = rom.reduce(structure)
    terms = ContactProblem.of(reduced, law).on(GRID, MARCH).solve([amplitude])
    modal = 2.0 * reduced.modal_damping @ np.square(reduced.carrier * amplitude)
    comes_in = terms.leaving[0] + modal
    taken = comes_in - taken_by_dampers(structure, reduced, amplitude, terms)
    swing = float((reduced.frequency * np.square(amplitude) * frictionless(reduced)).sum())
    assert taken >= -2 * MARCH * swing
    # the power is stated without the negative part that the march's end may leave
    assert terms.power[0] == pytest.approx(max(taken, 0.0), rel=1e-9, abs=1e-9 * swing)
    return taken / swing


@pytest.mark.oracle
@given(springs=SPRINGS, law=LAWS, amplitude=AMPLITUDES)
@few
def test_friction_takes_power(springs, law, amplitude):
    check_energy(rom.two_mass(**springs), law, amplitude)


@pytest.mark.oracle
@pytest.mark.parametrize("law", [rom.Tanh(2.0, 0.02), rom.Coulomb(2.0)], ids=str)
@pytest.mark.parametrize("amplitude", [(2.5, 1.5), (1.3, 0.2), (0.3, 1.5)])
def test_friction_takes_most_power_where_contacts_slip(law, amplitude):
    """Both slip, or one; far above what a march may miss."""
    assert check_energy(rom.two_mass(beta=0.01), law, amplitude) > 1e4 * MARCH


@given(k_p=st.floats(0.1, 8.0), law=LAWS, amplitude=AMPLITUDES)
@few
def test_the_sign_of_the_contact_coupling_does_not_matter(k_p, law, amplitude):
    reduced = [rom.reduce(rom.two_mass(k_p=k)) for k in (k_p, -k_p)]
    plus, minus = (ContactProblem.of(r, law).on(GRID, MARCH).solve([amplitude]).Q for r in reduced)
    assert np.all(np.abs(minus - plus) < 2 * MARCH * frictionless(reduced[0]))


@given(order=st.permutations(range(4)), springs=SPRINGS, amplitude=AMPLITUDES)
@few
def test_the_numbers_of_the_dofs_do_not_matter(order, springs, amplitude):
    structure, law = rom.two_mass(**springs), rom.Tanh((1.0, 2.0), 0.02)
    index = np.ix_(order, order)
    mass, stiffness = (np.asarray(m)[index] for m in (structure.mass, structure.stiffness))
    contact = [order.index(2), order.index(3)]
    renamed = rom.Structure(mass, stiffness, springs["beta"], contact=contact)
    reduced = [rom.reduce(s) for s in (structure, renamed)]
    Q, other = (ContactProblem.of(r, law).on(GRID, MARCH).solve([amplitude]).Q for r in reduced)
    assert np.all(np.abs(other - Q) < 2 * MARCH * frictionless(reduced[0]))


@given(amplitude=st.tuples(st.floats(0.5, 4.0), st.floats(0.5, 4.0)))
@settings(few, max_examples=5)
def test_which_mode_comes_first_does_not_matter(amplitude):
    """To the error of the discretisation, whose steps follow the phase of A."""
    structure, law, grid = rom.two_mass(), rom.Tanh(2.0, 0.2), Discretisation(512, 32)
    AB = ContactProblem.of(rom.reduce(structure), law).on(grid, 1e-7).solve([amplitude]).Q[0]
    swapped = rom.reduce(structure, modes=(1, 0))
    BA = ContactProblem.of(swapped, law).on(grid, 1e-7).solve([amplitude[::-1]]).Q[0]
    np.testing.assert_allclose(BA[::-1], AB, rtol=0, atol=1e-4 * np.abs(AB).max())


@pytest.fixture(scope="module")
def coulomb_model():
    return rom.tabulate(rom.reduce(rom.two_mass()), rom.Coulomb(2.0), (4.0, 4.0), 1e-2)


def march(model, durations, scale=1.0):
    """Return amplitudes after steps from rest, force and friction limit scaled together."""
    inputs = {k: scale * v if k.startswith("force") else v for k, v in INPUTS.items()}
    times = np.cumsum(durations)
    found = run(*(model, FORCE_PATTERNS, times), tolerance=1e-8, **inputs, limit_scale=scale)
    return amplitudes(found)[-1]


@pytest.mark.oracle
@given(scale=st.floats(1e-6, 1e6))
@few
def test_force_and_limit_scale_together_under_coulomb_friction(coulomb_model, scale):
    plain, scaled = march(coulomb_model, [200.0]), march(coulomb_model, [200.0], scale)
    np.testing.assert_allclose(scaled / scale, plain, rtol=1e-7)


@given(lengths=st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=60))
@few
def test_the_pattern_of_steps_does_not_matter(coulomb_model, lengths):
    durations = 200.0 * np.array(lengths) / np.sum(lengths)
    split, whole = march(coulomb_model, durations), march(coulomb_model, [200.0])
    np.testing.assert_allclose(split, whole, rtol=0, atol=1e-6 * np.abs(whole).max())


def test_units_do_not_matter():
    """A small stiff structure, in units of length, mass and rate far from 1."""
    length, stiffness, rate = 1e-9, 1e8, 1e3
    mass, force = stiffness / rate**2, stiffness * length
    plain = rom.two_mass(beta=0.01)
    scaled = rom.Structure(
        mass * np.asarray(plain.mass),
        stiffness * np.asarray(plain.stiffness),
        0.01 / rate,
        contact=(2, 3),
    )
    found = []
    for structure, law, L, m, r in (
        (plain, rom.Tanh(2.0, 0.02), 1.0, 1.0, 1.0),
        (scaled, rom.Tanh(2.0 * force, 0.02 * length * rate), length, mass, rate),
    ):
        unit, Omega, F = L * np.sqrt(m), 0.98 * r, 0.15 * m * r**2 * L
        reduced = rom.reduce(structure, (0,), carrier=(Omega,))
        model = rom.tabulate(reduced, law, (4.0 * unit,), 1e-2)
        found.append(rom.steady(model, (Omega,), ({0: F},)) / unit)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-10)
