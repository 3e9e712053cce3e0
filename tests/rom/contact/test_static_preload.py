"""Static equilibria under bolts and centrifugal loads: closed forms, least energy, vibration."""

from dataclasses import replace

import numpy as np
import pytest
from beside_oracle import with_laws
from elastic import cantilever
from oracles.system import Frictional
from oracles.time_integration import Integrator

from slipmode import rom
from slipmode.rom import full

STUCK, SLIPPING, OPEN = 0, 1, 2
MU, K_T, K_N = 0.3, 50.0, 80.0
SURFACE = rom.FrictionalContact(MU, 0.0, K_T, K_N)


def block(spring=10.0):
    """A mass on springs: along the contact, onto it, and one aside."""
    W = np.eye(3)[:, :2]
    return rom.Structure(np.eye(3), spring * np.eye(3), 0.01, contact=W)


def quiet(structure, law, force):
    return rom.preload(structure, law, force, warned=False)


# Closed forms


@pytest.mark.oracle
@pytest.mark.parametrize(("push", "slips"), [(2.0, False), (20.0, True)])
@pytest.mark.parametrize("along", [[1.0], [np.cos(0.6), np.sin(0.6)]], ids=["line", "plane"])
def test_a_block_pressed_and_pushed(push, slips, along):
    n, along = len(along), np.array(along)
    body = rom.Structure(np.eye(4), 10.0 * np.eye(4), contact=np.eye(4)[:, : n + 1])
    force = np.concatenate((push * along, [9.0], np.zeros(3 - n)))
    found = quiet(body, replace(SURFACE, tangents=n), force)
    N = 9.0 * K_N / (10.0 + K_N)
    held = MU * N if slips else push * K_T / (10.0 + K_T)
    np.testing.assert_allclose(found.contact_force, [*(held * along), N], rtol=1e-9)
    np.testing.assert_allclose(found.displacement[:n], (push - held) / 10.0 * along)
    assert found.state == [SLIPPING if slips else STUCK]
    np.testing.assert_allclose(found.tangential_share, held / (MU * N))


def stack(half=0.5, held=0.0):
    """Two bodies on each other, contacts at +-half: u, v, rotation, stretch of each.

    They do not bend, and float unless springs hold them.
    """
    W = np.zeros((8, 4))
    for k, x in enumerate((-half, half)):
        W[[0, 3, 4, 7], 2 * k] = 1.0, x, -1.0, -x
        W[[1, 2, 5, 6], 2 * k + 1] = -1.0, -x, 1.0, x  # the upper one comes down
    stretch = np.diag([0.0, 0.0, 0.0, 50.0] * 2)
    mass = np.diag([2.0, 2.0, 0.5, 0.1, 1.0, 1.0, 0.2, 0.05])
    return rom.Structure(mass, stretch + held * np.eye(8), 0.01, contact=W)


def bolt(place, tension):
    """Presses the bodies together there."""
    return tension * np.array([0.0, -1.0, -place, 0.0, 0.0, 1.0, place, 0.0])


@pytest.mark.oracle
@pytest.mark.parametrize("place", [0.0, 0.2, -0.45])
def test_a_bolted_stack_that_floats_shares_the_bolt_by_the_law_of_the_lever(place):
    structure = stack()
    found = quiet(structure, SURFACE, bolt(place, 7.0))
    np.testing.assert_allclose(found.normal_force, [3.5 - 7.0 * place, 3.5 + 7.0 * place])
    np.testing.assert_allclose(found.contact_force[::2], 0.0, atol=1e-12)
    momentum = structure.mass @ found.displacement
    np.testing.assert_allclose(momentum[:2] + momentum[4:6], 0.0, atol=1e-14)
    reduced = rom.reduce(structure, (3, 4), law=found.law)
    assert np.all(reduced.frequency > 1.0)
    again = quiet(structure, found.law, np.zeros(8))
    assert again.law == found.law
    assert not again.displacement.any()


def on_springs(mu, gaps):
    """A cantilever on eight contacts, some with gaps, and a force along and across it."""
    K, M = cantilever.beam()
    law = rom.FrictionalContact(mu, 0.0, K_T, 3000.0, gap=np.array(gaps))
    force = np.zeros(len(K))
    force[[4, 13, cantilever.TIP, cantilever.TIP - 1]] = 2.0, -1.5, 0.8, 6.0
    nodes = 3 * np.arange(8)
    W = np.zeros((len(K), 16))
    W[nodes, ::2] = W[nodes + 1, 1::2] = np.eye(8)
    return rom.Structure(M, K, contact=W), law, force


UNEVEN = 1e-3 * np.array([0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 5.0])
LOADED = {
    "frictionless": (*on_springs(0.0, UNEVEN), {OPEN, SLIPPING}),
    "friction": (*on_springs(0.3, np.zeros(8)), {OPEN, SLIPPING}),
    "beside the lap": (stack(held=0.5), SURFACE, bolt(0.8, 7.0), {OPEN, STUCK}),
}


@pytest.mark.oracle
@pytest.mark.parametrize("name", LOADED)
def test_forces_of_the_law_are_in_equilibrium(name):
    """K x + W f = F, f by the law from rest; the law about it has its normal forces and gaps."""
    structure, law, force, states = LOADED[name]
    found, W = quiet(structure, law, force), structure.directions
    x = (W.T @ found.displacement).reshape(-1, 2)
    opening = np.broadcast_to(law.gap, len(x)) - x[:, 1]
    N = law.normal_stiffness * np.maximum(-opening, 0.0)
    f = np.clip(law.tangential_stiffness * x[:, 0], -law.mu * N, law.mu * N)
    size = np.abs(force).max()
    np.testing.assert_allclose(found.contact_force, np.ravel([f, N], "F"), atol=1e-8 * size)
    left = structure.stiffness @ found.displacement + W @ np.ravel([f, N], "F") - force
    assert np.abs(left).max() < 1e-8 * size
    assert set(found.state) >= states
    np.testing.assert_allclose(found.law.preload, N, atol=1e-8 * size)
    np.testing.assert_allclose(found.law.gap, np.maximum(opening, 0.0), atol=1e-12)


def beam():
    """A cantilever on a surface at three nodes: along it, onto it."""
    K, M = cantilever.beam()
    W = np.zeros((len(K), 6))
    for k, node in enumerate((2, 4, 7)):
        W[3 * node, 2 * k] = W[3 * node + 1, 2 * k + 1] = 1.0
    return rom.Structure(M, K, 0.002, contact=W)


CLEARANCE = rom.FrictionalContact(0.4, 0.0, 150.0, 200.0, gap=(0.0, 0.0, 0.05))
STATIC = np.zeros(24)
STATIC[[10, 13]] = 1.5, 2.0
OMEGA = 9.0


def at_tip(axial, transverse):
    force = np.zeros(24)
    force[[cantilever.TIP - 1, cantilever.TIP]] = axial, transverse
    return force


def loaded(law, force, static, Omega, t_end, steps, found=None):
    """Motion under both forces by the oracle, from the equilibrium or from rest."""
    body, gaps = beam(), np.broadcast_to(law.gap, 3)
    k_t, k_n = law.tangential_stiffness, law.normal_stiffness
    contacts = [Frictional(law.mu, 0.0, k_t, k_n, gap) for gap in gaps]
    system = with_laws(body, contacts)
    inner = Integrator(system, np.column_stack((force, static)), t_end / steps)
    if found is not None:
        inner.z[:24], x = found.displacement, system.W.T @ found.displacement
        inner.u[:] = np.tile([k_t, k_n], 3) * x - found.contact_force
        inner.memory[:] = x[::2] - found.contact_force[::2] / k_t
    t = np.linspace(0.0, t_end, steps + 1)
    z, _ = inner.advance(np.column_stack((np.cos(Omega * t), np.ones(steps + 1))), 1)
    return t[1:], z[:, :24]


def shaken(law, force, times):
    excitation = full.Excitation.harmonic(beam(), (force,), (OMEGA,))
    return full.integrate(beam(), law, excitation, times, step=2e-3)


@pytest.mark.oracle
@pytest.mark.parametrize("pull", [0.0, 3.0])
def test_what_vibrates_about_it_is_the_structure_with_the_law_it_returns(pull):
    """Contacts slip, open and touch down, whether friction holds a part of the load or none."""
    static = STATIC + at_tip(pull, 0.0)
    found = rom.preload(beam(), CLEARANCE, static)
    assert (found.tangential_share.max() > 0.2) == (pull > 0.0)
    force = at_tip(18.0, 0.6)
    t, x = loaded(CLEARANCE, force, static, OMEGA, 15.0, 15000, found)
    about = shaken(found.law, force, t[::50])
    off = x[::50] - found.displacement - about.displacement
    assert np.linalg.norm(off) < 1e-3 * np.linalg.norm(about.displacement)
    normal = about.contact_force[:, 1::2] + found.law.preload
    assert np.all((normal <= 0.0).any(axis=0) & (normal > 0.0).any(axis=0))


@pytest.mark.oracle
@pytest.mark.parametrize("tangents", [1, 2])
def test_the_law_about_it_is_the_whole_law_from_the_equilibrium(tangents):
    """Along a path on which contacts stick, slip, open and touch down."""
    law = replace(SURFACE, mu=0.5, tangents=tangents)
    at_rest = np.array([0.02, -0.05, 0.03])[-tangents - 1 :]
    path = np.random.default_rng(5).normal(0.0, 0.05, (200, tangents + 1)).cumsum(axis=0)
    whole = law.elements(tangents + 1)
    rest, memory = whole.march(at_rest[np.newaxis])
    forces, _ = whole.march(at_rest + path, memory)
    about = replace(law, preload=rest[0, -1], tangential_preload=rest[0, :-1])
    found, _ = about.elements(tangents + 1).march(path)
    np.testing.assert_allclose(found, forces - rest, atol=1e-9)
    assert (forces[:, -1] == 0.0).any()
    assert (forces[:, -1] > 0.0).any()


def test_only_forces_at_rest_without_a_normal_direction_are_neglected():
    """A block that a Jenkins element holds, beside a contact that presses on it."""
    law = rom.Contacts([(SURFACE, (0, 1)), (rom.Jenkins(1.0, 30.0), (2,))])
    body = rom.Structure(np.eye(3), 10.0 * np.eye(3), 0.01, contact=np.eye(3))
    with pytest.warns(rom.ValidityWarning, match=r"force at contact 1 is 75 % of its friction"):
        found = rom.preload(body, law, [1.0, 2.0, 1.0])
    slips = MU * 2.0 * K_N / (10.0 + K_N)
    assert found.law.groups[0][0].tangential_preload == pytest.approx((slips,))


@pytest.mark.oracle
def test_the_slow_flow_about_it_is_the_loaded_structure():
    """One mode across the beam: a contact that is open at rest touches down, another lifts off."""
    law = rom.FrictionalContact(0.4, 0.0, 15.0, 20.0, gap=(0.0, 0.0, 0.3))
    force, found = at_tip(0.0, 0.3), quiet(beam(), law, STATIC)
    Omega = 0.98 * rom.reduce(beam(), (0,), law=found.law).frequency
    reduced = rom.reduce(beam(), (0,), law=found.law, carrier=Omega, force_patterns=(force,))
    periods, steps = 208, 256
    t_end = 2.0 * np.pi / Omega[0] * periods
    t, x = loaded(law, force, STATIC, Omega[0], t_end, periods * steps)
    last = slice(-8 * steps, None)
    mode = x[last] @ beam().mass @ reduced.mode_shapes[:, 0]
    reference = np.mean(mode * np.exp(-1j * Omega[0] * t[last]))
    model = rom.tabulate(reduced, found.law, (0.06,), tolerance=1e-3)
    assert rom.steady(model, Omega, (force,))[0] == pytest.approx(reference, rel=2e-3)


def test_unloading_leaves_the_tractions_of_the_largest_force():
    """Slip at 30 N takes the block to 7 mm; 25 of the 50 N of unloading are the contact's."""
    block = rom.Structure(np.eye(2), 1e4 * np.eye(2), contact=np.eye(2))
    law = rom.FrictionalContact(0.3, 100.0, tangential_stiffness=1e4, normal_stiffness=1e4)
    loaded = rom.preload(block, law, {0: 50.0})
    unloaded = rom.preload(block, law, {0: 50.0}, history=[{0: 20.0}, {0: 100.0}])
    np.testing.assert_allclose([loaded.contact_force[0], loaded.displacement[0]], [25.0, 2.5e-3])
    np.testing.assert_allclose(
        [unloaded.contact_force[0], unloaded.displacement[0]], [5.0, 4.5e-3]
    )
    assert unloaded.law.tangential_preload == pytest.approx((5.0,))
    with pytest.raises(rom.SlipmodeError, match=r"^history: all contacts must be rom\.Frictional"):
        mixed = rom.Contacts([(law, (0, 1)), (rom.Jenkins(1.0, 2.0), (2,))])
        rom.preload(
            rom.Structure(np.eye(3), np.eye(3), contact=np.eye(3)),
            mixed,
            {1: 1.0},
            history=[{0: 1.0}],
        )


@pytest.mark.parametrize("push", [0.0, 20.0])
def test_equilibria_of_all_limits_in_two_directions_are_within_friction(push):
    """Of two bodies on inclined surfaces, with a spring between them."""
    law = replace(SURFACE, tangents=2)
    W = np.zeros((6, 6))
    W[[0, 1, 2], [0, 1, 2]] = 1.0
    W[3:, 3:] = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    K = 10.0 * np.eye(6) + 20.0 * np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(3))
    body = rom.Structure(np.eye(6), K, 0.01, contact=W)
    force = np.concatenate(([push, 0.0, 60.0], W[3:, 5] * 50.0))
    ends = rom.preload(body, law, force, bounds=True)
    assert len(ends) >= 4
    for each in ends:
        left = body.stiffness @ each.displacement + body.directions @ each.contact_force
        np.testing.assert_allclose(left, force, atol=1e-8)
        assert each.tangential_share.max() <= 1.0
    N = np.array([each.normal_force for each in ends])
    direct = quiet(body, law, force).normal_force
    assert np.all((N.min(axis=0) < direct) & (direct < N.max(axis=0)))


# Refusals


REFUSED = [
    (block(), rom.Jenkins(1.0, 2.0), {1: 1.0}, "law: has no normal direction for a s"),
    (block(), SURFACE, {7: 1.0}, "static_force: DOF 7 is out of range, allowed: 0 to 2"),
    (block(), SURFACE, {1: -1.0}, "static_force: all contacts are open under this force; "),
    (stack(), SURFACE, -bolt(0.0, 1.0), "static_force: no equilibrium was found"),
    (stack(), SURFACE, {1: 1.0}, "static_force: excites a rigid-body mode"),
]


def test_refuses_a_tangential_preload_above_the_friction_limit():
    law = replace(SURFACE, preload=2.0, tangential_preload=-0.7)
    with pytest.raises(rom.SlipmodeError, match=r"mu times the preload, 0.6 N at contact 0; got"):
        law.elements(2)


@pytest.mark.parametrize(("structure", "law", "force", "message"), REFUSED)
def test_refuses_in_one_line(structure, law, force, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.preload(structure, law, force)
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)
