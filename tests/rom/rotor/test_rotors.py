"""Rotors: frequencies over speeds, and models whose frequencies follow the rotor speed.

The oracle is a beam of unit length, mass and bending stiffness that rotates about its clamped end,
assembled anew at each speed, and the average-acceleration rule with an exact Jenkins element.
"""

import numpy as np
import pytest
import scipy

from slipmode import fmu, rom, runner

# Flapwise, at speeds 0, 2, ..., 10: A. D. Wright et al., J. Appl. Mech. 49 (1982).
WRIGHT = np.array([[3.5160, 4.1373, 5.5850, 7.3604, 9.2568, 11.2023]]).T
WRIGHT = np.hstack((WRIGHT, [[22.0345], [22.6149], [24.2733], [26.8091], [29.9954], [33.6404]]))
CONTACT, TIP, ORDER, FORCE, BETA = 2, 6, 2.0, 0.2, 0.0017
LAW = rom.Jenkins(limit=1.0, stiffness=3.0)
LOW, HIGH = SPEEDS = 2.04, 2.39  # around the crossing with the engine order


def beam(elements, speed, chordwise=False):
    """Mass and stiffness of the rotating beam, without its clamped DOFs."""
    h, size = 1.0 / elements, 2 * elements + 2
    M, K = np.zeros((size, size)), np.zeros((size, size))
    s, w = np.polynomial.legendre.leggauss(5)
    s, w = 0.5 * s + 0.5, 0.5 * w * h
    ends = [2, -3, 0, 1], [h, -2 * h, h, 0], [-2, 3, 0, 0], [h, -h, 0, 0]
    cubics = [np.poly1d(coefficients) for coefficients in ends]
    shape, slope, bend = (np.array([c.deriv(k)(s) for c in cubics]) / h**k for k in range(3))
    for e in range(elements):
        dofs, tension = slice(2 * e, 2 * e + 4), 0.5 * speed**2 * (1.0 - (h * (e + s)) ** 2)
        M[dofs, dofs] += (shape * w) @ shape.T
        K[dofs, dofs] += (bend * w) @ bend.T + (slope * w * tension) @ slope.T
    return M[2:, 2:], (K - chordwise * speed**2 * M)[2:, 2:]


def beam_squares(elements, speed, chordwise=False, spring=0.0):
    M, K = beam(elements, speed, chordwise)
    K[CONTACT, CONTACT] += spring
    return scipy.linalg.eigh(K, M, eigvals_only=True)


def rotor_of(elements, chordwise=False):
    (M, K_0), (_, K) = beam(elements, 0.0), beam(elements, 1.0, chordwise)
    rest = rom.Structure(M, K_0, BETA, contact=[CONTACT])
    return rom.RotatingStructure.from_speeds(rest, rom.Structure(M, K, contact=[CONTACT]), 1.0)


@pytest.fixture(scope="module")
def model():
    reduced = rom.reduce_rotating(rotor_of(4), [0], [ORDER], SPEEDS, LAW)
    return rom.tabulate(reduced, LAW, amplitude=(3.0,), harmonics=5, detuning=True)


@pytest.mark.oracle
@pytest.mark.parametrize("chordwise", [False, True])
def test_frequencies_of_a_rotating_beam_follow_the_speed(chordwise):
    rotor, speeds = rotor_of(10, chordwise), np.arange(11.0)
    found = rotor.modes(speeds, rom.Jenkins(1.0, 1e-9), 2)
    for speed, frequency in zip(speeds, found.frequency, strict=True):
        exact = np.sqrt(beam_squares(10, speed, chordwise)[:2])
        np.testing.assert_allclose(frequency, exact, rtol=1e-8)
    published = np.sqrt(WRIGHT**2 - chordwise * speeds[::2, np.newaxis] ** 2)
    np.testing.assert_allclose(found.frequency[::2], published, rtol=2e-4)  # 1.1e-4
    squares = beam_squares(10, found.crossings(ORDER)[0], chordwise)
    assert np.sqrt(squares[0]) == pytest.approx(ORDER * found.crossings(ORDER)[0], rel=2e-4)


@pytest.mark.oracle
def test_modes_with_gyroscopic_forces_are_whirls():
    """A mass on equal springs, seen from the rotor: its frequencies are omega -+ speed."""
    mass = rom.Structure(np.eye(2), 3.0 * np.eye(2), contact=[0, 1])
    rotor = rom.RotatingStructure(mass, -np.eye(2), [[0.0, -2.0], [2.0, 0.0]])
    speeds = [0.1, 0.5, 1.0, 1.5]
    found = rotor.modes(speeds, rom.Jenkins(1.0, 1.0), 2)
    np.testing.assert_allclose(found.frequency, [[2.0 - n, 2.0 + n] for n in speeds], rtol=1e-9)


def sweep(model, duration, steps, **options):
    c = fmu.Component(model, [{TIP: 1.0}], mode_names=("A",), **options)
    rate = ORDER * (HIGH - LOW) / duration
    c.set_inputs(force_A=FORCE, frequency_A=ORDER * LOW, frequency_rate_A=rate)
    found = []
    for k in range(steps):
        c.do_step(k * duration / steps, duration / steps)
        found.append(c.outputs())
    return {name: np.array([each[name] for each in found]) for name in found[0]}


def full_order(duration, steps):
    """Displacement of the tip (steps + 1,) while K(speed) changes in time."""
    (M, K_0), (_, K) = beam(4, 0.0), beam(4, 1.0)
    K_1, C, h, k_t = K - K_0, BETA * K_0, duration / steps, LAW.stiffness
    unit, q, slider = np.eye(8), 0.25 * h * h, 0.0
    x, v, a, tip = np.zeros(8), np.zeros(8), np.linalg.solve(M, FORCE * unit[TIP]), [0.0]
    for k in range(1, steps + 1):
        rise = (HIGH - LOW) * k / steps
        K = K_0 + (LOW + rise) ** 2 * K_1
        x, v = x + h * v + q * a, v + 0.5 * h * a
        f = FORCE * np.cos(ORDER * (LOW + 0.5 * rise) * k * h) * unit[TIP] - C @ v - K @ x
        load = np.column_stack((f, unit[CONTACT]))
        free, by_contact = np.linalg.solve(M + 0.5 * h * C + q * K, load).T
        stuck = k_t * (x + q * free - slider)[CONTACT] / (1 + k_t * q * by_contact[CONTACT])
        g = min(max(stuck, -LAW.limit), LAW.limit)
        a = free - g * by_contact
        x, v = x + q * a, v + 0.5 * h * a
        slider = slider if g == stuck else x[CONTACT] - g / k_t
        tip.append(x[TIP])
    return np.array(tip)


@pytest.mark.oracle
def test_frequencies_and_a_run_up_through_resonance_are_those_of_full_order(model):
    for speed in np.linspace(*SPEEDS, 10):
        (found,) = model.reduced.natural_at(np.array([ORDER * speed]))
        exact = np.sqrt(beam_squares(4, speed, spring=LAW.stiffness)[0])
        assert found == pytest.approx(exact, rel=1e-4)  # 1e-5
    tip = full_order(210.0, 45_000)
    found = sweep(model, 210.0, 300, contact=True, elastic=[TIP])
    off = np.linalg.norm(found["x_6"] - tip[150::150]) / np.linalg.norm(tip[150::150])
    assert off < 0.01  # 0.0045
    largest = np.hypot(found["A_re"], found["A_im"]).max() * abs(model.reduced.mode_shapes[TIP, 0])
    assert 2.0 * largest == pytest.approx(np.abs(tip).max(), rel=0.01)


def test_steady_states_of_two_modes_are_those_at_constant_speeds():
    rotor = rom.RotatingStructure(rom.two_mass(0.01), np.diag([1.0, 1.5, 0.2, 0.2]))
    orders, law, forces = np.array([2.0, 3.4]), rom.Coulomb(2.0), [{0: 0.15}, {1: 0.25}]
    reduced = rom.reduce_rotating(rotor, [0, 1], orders, (0.52, 0.62))
    model = rom.tabulate(reduced, law, amplitude=(3.2, 1.0), tolerance=5e-3)
    for speed in (0.55, 0.57, 0.59):
        there = rom.reduce(rotor.at_speed(speed), carrier=orders * speed)
        exact = rom.steady_state(there, law, orders * speed, forces).amplitude
        found = rom.steady(model, orders * speed, forces)
        assert np.all(np.abs(found - exact) < 2e-3 * np.abs(exact))  # 1.2e-3
    with pytest.raises(rom.SlipmodeError, match="times one rotor speed"):
        rom.steady(model, [1.1, 1.9], forces)


SCENE = """model = {{file = "rotor.npz"}}
forcing.A = {{dof = 6, amplitude = 0.2, engine_order = {}, rotor_speed = {}}}
run = {{duration = 60.0, step = 2.0}}
log = {{rerun = false}}
"""


def test_a_saved_model_its_fmu_and_its_scene_follow_the_speed(model, tmp_path):
    model.save(tmp_path / "rotor.npz")
    own = rom.Model.load(tmp_path / "rotor.npz")
    exact = sweep(own, 60.0, 30)["A_re"]
    path = fmu.export(own, tmp_path / "rotor.fmu", [{TIP: 1.0}], mode_names=("A",))
    rate = ORDER * (HIGH - LOW) / 60.0
    start = {"force_A": FORCE, "frequency_A": ORDER * LOW, "frequency_rate_A": rate}
    options = {"start_values": start, "stop_time": 60.0, "output_interval": 2.0}
    found = pytest.importorskip("fmpy").simulate_fmu(path, output=["A_re"], **options)
    np.testing.assert_allclose(found["A_re"][1:], exact, rtol=0, atol=1e-9)
    ramp = [[t, float(speed * 30 / np.pi)] for t, speed in ((0.0, LOW), (60.0, HIGH))]
    run = runner.run(runner.parse_scene(SCENE.format(2, ramp), tmp_path), tmp_path)
    found = run.read().channels["/modes"].values
    np.testing.assert_allclose(found[1:, 0], exact, rtol=0, atol=2e-5)  # 6e-6, by its start
    for keys, words in (((3, ramp), "engine_order: must be 2"), ((2, 14.0), "at 19.48")):
        with pytest.raises(rom.SlipmodeError, match=words):
            runner.make_plan(runner.parse_scene(SCENE.format(*keys), tmp_path))
    for call in (rom.backbone, rom.limit_cycles, lambda model: rom.decay_rates(model, [0.5])):
        with pytest.raises(rom.SlipmodeError, match="needs a constant rotor speed"):
            call(own)


PLAIN, SKEW = rom.two_mass(0.01), np.eye(4, k=1) - np.eye(4, k=-1)
K, reduced = PLAIN.stiffness, rom.reduce_rotating
ROTOR, GYRO = rom.RotatingStructure(PLAIN, np.eye(4)), rom.RotatingStructure(PLAIN, K, SKEW)
REFUSED = {
    "stiffness: .*circulatory": lambda: rom.Structure(PLAIN.mass, K + SKEW, contact=[2]),
    "damping: .*gyroscopic": lambda: rom.Structure(PLAIN.mass, K, K + SKEW, contact=[2]),
    "spin_stiffness: .*circulatory": lambda: rom.RotatingStructure(PLAIN, SKEW),
    "speeds: at 2 rad/s.*softening": lambda: rom.RotatingStructure(PLAIN, -K).modes([0.0, 2.0]),
    "engine_orders .* speeds: must": lambda: reduced(ROTOR, [0], [0.5], (0.5, 0.6)),
    "narrower range": lambda: reduced(rotor_of(4), [0], [2.0], (1.0, 6.0), LAW),
    "gyroscopic: changes": lambda: reduced(GYRO, [0], [2.0], (0.5, 0.6)),
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_is_not_modelled_is_refused_by_name(words):
    with pytest.raises(rom.SlipmodeError, match=words):
        REFUSED[words]()
