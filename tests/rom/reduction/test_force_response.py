"""Forces that act on more than the mode they drive: other modes, the contacts, and statically."""

from functools import cache

import numpy as np
import pytest
import scipy.linalg
from beside_oracle import steady_amplitudes, system_of, vector
from elastic.cantilever import cantilever
from oracles.harmonic_balance import balance

from benchmarks import cases
from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.reduction.force_response import AppliedForces

LAW = rom.Jenkins(limit=(0.2, 0.2, 0.02, 0.05), stiffness=(60.0, 40.0, 10.0, 30.0))
BODY = cantilever(LAW)
DASHPOT = 0.1  # what the contacts of the linear chain are [N s/m]


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:friction does not act")
@pytest.mark.parametrize(
    ("modes", "forces", "tolerance"),
    [
        ((0,), ({7: 1.0},), 1e-4),  # on a contact
        ((2,), ({1: 1.0, 12: -0.4},), 1e-4),
        ((1, 0), ({19: 1.0, 5: 0.3}, {7: 1.0}), 1.2e-3),  # stated for two modes
    ],
)
def test_every_dof_moves_as_in_a_direct_solve_where_contacts_stick(modes, forces, tolerance):
    law = rom.Jenkins(limit=1e6, stiffness=LAW.stiffness)
    reduced = rom.reduce(BODY, modes, law=law)
    frequency = reduced.frequency * (0.98, 1.02)[: len(modes)]
    found = rom.steady_state(reduced, law, frequency, forces)
    W = np.asarray(BODY.directions)
    K = BODY.stiffness + (W * LAW.stiffness) @ W.T
    for j, (force, nu) in enumerate(zip(forces, frequency, strict=True)):
        D = K + 1j * nu * BODY.damping - nu**2 * BODY.mass
        x = np.linalg.solve(D, vector(force, 24))
        phi = reduced.mode_shapes[:, j]
        assert found.amplitude[j] == pytest.approx(0.5 * phi @ BODY.mass @ x, rel=tolerance)
        moved = [found.displacement(dof)[j] for dof in range(24)]
        np.testing.assert_allclose(moved, np.abs(x), rtol=tolerance)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:friction does not act")
def test_a_loaded_dof_has_the_static_flexibility_of_the_modes_that_are_neglected():
    """What is left are their dynamics, phi^2 nu^2 / (omega^2 (omega^2 - nu^2))."""
    n, dof, law = 40, 30, rom.Jenkins(1e6, 1.0)
    K = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    structure = rom.Structure(np.eye(n), K, 0.0, contact=[9])
    reduced = rom.reduce(structure, (0,), law=law, smallest_response=1.0)
    nu = 0.95 * reduced.frequency
    found = rom.steady_state(reduced, law, nu, [{dof: 1.0}]).displacement(dof)[0]
    stuck = K + np.diag(np.eye(n)[9])
    exact = abs(np.linalg.inv(stuck - nu[0] ** 2 * np.eye(n))[dof, dof])
    squares, shapes = scipy.linalg.eigh(stuck)
    left = slice(1 + reduced.nonresonant_frequency.size, None)
    share = shapes[dof, left] ** 2 / squares[left]
    dynamic = np.sum(share * nu[0] ** 2 / (squares[left] - nu[0] ** 2))
    assert dynamic < 0.02 * share.sum()
    assert abs(found - exact) == pytest.approx(dynamic, rel=1e-2)


@cache
def viscous_chain():
    """A chain with linear contacts, forced at one mass: case, forces, model, amplitudes."""
    case = cases.Chain(20).case(point_forces=True)
    force = ({3: 0.02}, {3: 0.03})
    reduced = rom.reduce(case.structure, carrier=case.frequency)
    law = rom.Tanh(20.0 * DASHPOT, 20.0)
    model = rom.tabulate(reduced, law, (0.8, 0.4), 2e-5, harmonics=5, warned=False)
    return case, force, model, rom.steady(model, case.frequency, force)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore:friction acts as a dashpot")
@pytest.mark.parametrize("way", [rom.reconstruct, rom.sum_harmonics])
def test_fast_motion_is_that_of_a_direct_solve_where_contacts_are_linear(way):
    """Displacements of all DOFs and contacts to the tolerance of the table; forces of dashpots."""
    case, force, model, a = viscous_chain()
    s, times = case.structure, np.linspace(30.0, 60.0, 601)
    modal = [model.reduced.modal_force(j, pattern) for j, pattern in enumerate(force)]
    ends = np.array([0.0, 60.0])
    trajectory = rom.SlowTrajectory(
        time=ends,
        amplitude=np.tile(a, (2, 1)),
        angle=np.outer(ends, case.frequency),
        frequency=np.array([case.frequency]),
        frequency_rate=np.zeros((1, 2)),
        force=np.array([modal], dtype=complex),
        force_rate=np.zeros((1, 2), dtype=complex),
        force_response=AppliedForces.of(model.reduced, force, s),
    )
    motion = way(model, trajectory, np.concatenate((np.linspace(0.0, 29.0, 580), times)))
    C = s.damping + DASHPOT * s.directions @ s.directions.T
    x, v = np.zeros((2, times.size, s.n_dofs))
    for pattern, nu in zip(force, case.frequency, strict=True):
        D = s.stiffness + 1j * nu * C - nu**2 * s.mass
        waves = np.outer(np.exp(1j * nu * times), np.linalg.solve(D, vector(pattern, s.n_dofs)))
        x, v = x + waves.real, v + (1j * nu * waves).real
    late = slice(580, None)
    for found, exact, tolerance in (
        (motion.elastic(model, range(s.n_dofs))[late], x, 2e-5),
        (motion.displacement[late], x @ s.directions, 2e-5),
        # summed, it is what all other forces leave
        (motion.force[late], DASHPOT * v @ s.directions, 2e-3),
    ):
        off = np.sqrt(np.mean((found - exact) ** 2, axis=0) / np.mean(exact**2, axis=0))
        assert off.max() < tolerance


@pytest.mark.oracle
def test_modes_go_on_as_they_were_where_forces_jump():
    """From rest: what the new forces maintain and what the amplitudes add are zero together."""
    _, force, model, _ = viscous_chain()
    reduced = model.reduced
    nu, angle = reduced.carrier, np.array([2.0, 5.0])
    applied = AppliedForces.of(reduced, force)
    jump = applied.modal * np.exp([0.3j, -1.1j])
    a = applied.free_vibration(jump, nu, angle)
    assert np.all(np.abs(a) > 1e-3)
    gamma, omega = reduced.modal_damping, reduced.frequency
    D = omega**2 - nu[:, np.newaxis] ** 2 + 1j * nu[:, np.newaxis] * gamma  # [force, mode]
    on_modes = np.array([vector(f, 20).real @ reduced.mode_shapes for f in force])
    turned = on_modes * (jump / applied.modal * np.exp(1j * angle))[:, np.newaxis]
    response = turned / D
    slow = 2.0 * a * np.exp(1j * angle) - np.diag(response)  # the amplitude has its own force
    free = -0.5 * gamma + 1j * np.sqrt(omega**2 - 0.25 * gamma**2)
    displacement = response.sum(axis=0) + slow
    velocity = (1j * nu[:, np.newaxis] * response).sum(axis=0) + free * slow
    scale = np.abs(slow).max()
    np.testing.assert_allclose(displacement.real, 0.0, atol=1e-12 * scale)
    np.testing.assert_allclose(velocity.real, 0.0, atol=1e-10 * scale)


def test_a_component_goes_on_as_it_was_where_forces_jump():
    """By the core what `free_vibration` says, for a later jump; nothing where it starts."""
    case, force, model, a = viscous_chain()
    component = Component(model, force, warned=False)
    component.reset(amplitude=a)
    component.set_inputs(**dict(zip(("frequency_A", "frequency_B"), case.frequency, strict=True)))

    def step(duration, **inputs):
        component.set_inputs(**inputs)
        component.do_step(component.time, duration)
        out = component.outputs()
        angle = np.array([out["theta_A"], out["theta_B"]])
        return np.array([out[f"{mode}_re"] + 1j * out[f"{mode}_im"] for mode in "AB"]), angle

    before, angle = step(3.0, force_A=1.0, force_B=1.0)
    np.testing.assert_allclose(before, a, rtol=1e-3)  # steady: nothing was added at the start
    after, _ = step(1e-9, force_A=0.25, force_B=1.0, phase_B=2.0)
    applied = AppliedForces.of(model.reduced, force)
    jump = applied.modal * np.array([-0.75, np.exp(2j) - 1.0])
    added = applied.free_vibration(jump, np.array(case.frequency), angle)
    np.testing.assert_allclose(after - before, added, rtol=1e-6)
    again, _ = step(1e-9, force_A=0.25)
    np.testing.assert_allclose(again, after, rtol=1e-7)


# Forces that move the contacts past the mode that they drive: mode, DOF, detuning, size


@pytest.mark.oracle
@pytest.mark.parametrize(
    "case",
    [(1, 19, -0.0287, 0.537), pytest.param((0, 7, -0.0131, 0.107), marks=pytest.mark.slow)],
)
def test_a_table_knows_what_its_force_does_past_the_mode(case):
    """Steady states of slipping contacts by harmonic balance, within both tolerances."""
    mode, dof, detuning, size = case
    carrier = rom.reduce(BODY, (mode,), law=LAW).frequency * (1.0 + detuning)
    given = [rom.reduce(BODY, (mode,), law=LAW, carrier=carrier, force_patterns=patterns)
             for patterns in (({dof: -3.0},), None)]  # fmt: skip
    force, project = vector({dof: size}, 24), given[0].mode_shapes[:, 0] @ BODY.mass
    system = system_of(BODY, LAW)
    few, exact = (0.5 * project @ balance(system, float(carrier[0]), force, harmonics=H)[1]
                  for H in (5, 9))  # fmt: skip
    model, ignorant = (
        rom.tabulate(each, LAW, (1.4 * abs(exact),), tolerance, warned=False)
        for each, tolerance in zip(given, (1e-3, 1e-2), strict=True)
    )
    found = rom.steady(model, carrier, ({dof: size},))[0]
    assert abs(found - exact) < 1e-3 * abs(exact) + abs(exact - few)
    without = rom.steady(ignorant, carrier, ({dof: size},))[0]
    assert abs(without - exact) < 1e-2 * abs(exact) + abs(exact - few)


@pytest.mark.oracle
@pytest.mark.parametrize(("dof", "size"), [(0, 0.15), (1, 0.5)])
def test_forces_on_rigid_contacts_move_the_mode(dof, size):
    """On the contact of the mode, or on one that is coupled to it, by time integration."""
    structure, law = rom.two_mass(), rom.Tanh(2.0, 0.02)
    force = {0: 0.1, 2 + dof: size}
    reduced = rom.reduce(structure, (0,), carrier=(0.98,), force_patterns=(force,))
    model = rom.tabulate(reduced, law, (4.0,), tolerance=1e-3)
    found = rom.steady(model, (0.98,), (force,))
    expected, error = steady_amplitudes(
        system_of(structure, law), reduced, (0.98,), (force,), tolerance=1e-4, steps=256
    )
    assert abs(found - expected) < 1e-3 * abs(expected) + error


def test_a_force_that_reaches_neither_mode_nor_contacts_moves_nothing():
    reduced = rom.reduce(rom.two_mass())
    assert reduced.is_moved_by(0, {0: 1.0})
    assert reduced.is_moved_by(0, {2: 1.0})
    assert not reduced.is_moved_by(0, {1: 1.0})
    assert not reduced.is_moved_by(0, {2: 0.0})
    assert not rom.reduce(rom.two_mass(), formulation="paper").is_moved_by(0, {2: 1.0})
