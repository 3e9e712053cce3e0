"""The component against equations of motion, independent time integration, and energy."""

from functools import cache

import numpy as np
import pytest
from elastic import cantilever
from oracles.system import System, Tanh, jenkins
from oracles.time_integration import integrate
from scipy.integrate import simpson, solve_ivp
from stepping import HELD, amplitude, component, march, model, model_with_steady_states

from slipmode import fmu, rom

pytestmark = [pytest.mark.quick, pytest.mark.oracle]

# One mode without contacts: x'' + 2 d x' + (w^2 + d^2) x = F cos(theta)

DECAY, FREQUENCY, FORCING = 0.5, 100.0, 99.2
LOSS = 2.0 * DECAY / FREQUENCY
ONSET = 0.01  # of the force [s]
LINEAR = {  # inputs, angle and magnitude of the force, t seconds after its onset
    "constant": ({}, lambda t: 0.0, lambda t: 1.0),
    "ramp": ({"force_rate_A": 0.3}, lambda t: 0.0, lambda t: 1.0 + 0.3 * t),
    "phase": ({"phase_A": 0.7, "phase_rate_A": 0.4}, lambda t: 0.7 + 0.4 * t, lambda t: 1.0),
    "sweep": ({"frequency_rate_A": 0.5}, lambda t: 0.25 * t**2, lambda t: 1.0),
    "jump": ({}, lambda t: float(t > 0.5), lambda t: 1.0 if t <= 0.5 else -0.4),
    "halt": (  # the phase halts, the force goes on
        *({"phase_rate_A": 0.4, "force_rate_A": 0.3}, lambda t: 0.4 * min(t, 0.5)),
        lambda t: 1.0 + 0.3 * t,
    ),
}
LATER = {"jump": {"force_A": -0.4, "phase_A": 1.0}, "halt": {"phase_rate_A": 0.0}}  # at 0.5 s


def linear_motion(times, angle, force):
    """Displacements from rest, by an integrator of high order."""

    def rate(t, y):
        drive = force(t - ONSET) * np.cos(FORCING * t + angle(t - ONSET))
        return y[1], drive - 2.0 * DECAY * y[1] - (FREQUENCY**2 + DECAY**2) * y[0]

    options = {"rtol": 1e-10, "atol": 1e-13, "max_step": 0.01}
    return solve_ivp(rate, (ONSET, times[-1]), (0.0, 0.0), "DOP853", times, **options).y[0]


@pytest.mark.parametrize("kind", LINEAR)
def test_a_linear_mode_follows_its_equation_of_motion(kind):
    """The slow flow neglects terms of the order of the square of the loss factor."""
    inputs, angle, force = LINEAR[kind]
    of = rom.model_of_rates(
        lambda r: (DECAY + 0.0 * r, FREQUENCY + 0.0 * r), amplitude=[0.1], mode_shapes=[[1.0]]
    )
    stepped = fmu.Component(of, ({0: 1.0},), contact=True, elastic=(0,), tolerance=1e-10)
    stepped.set_inputs(frequency_A=FORCING)
    stepped.do_step(0.0, ONSET)
    stepped.set_inputs(force_A=1.0, **inputs)
    rows = march(stepped, [0.18, 0.32])
    stepped.set_inputs(**LATER.get(kind, {}))
    rows = np.vstack((rows, march(stepped, np.tile([0.0173, 0.31, 0.002], 12))))
    exact = linear_motion(rows[:, 0], angle, force)
    error = rows[:, stepped.output_names.index("x_0")] - exact
    assert np.abs(error).max() < LOSS**2 * np.abs(exact).max()


# Contacts

ALONE, BOTH = ((0, 0.15, 0.9825),), ((0, 0.15, 0.98), (1, 0.25, 1.65))


@cache
def two_mass_motion(forces, end, step):
    """Motion from rest and contact forces, under forces ((DOF, amplitude, frequency), ...)."""
    s = rom.two_mass(beta=0.01)
    system = System(s.mass, s.damping, s.stiffness, np.eye(4)[:, 2:], [Tanh(2.0, 0.02)] * 2)
    columns = np.stack([size * np.eye(4)[dof] for dof, size, _ in forces], axis=1)

    def signals(t):
        return np.cos(np.outer(t, [frequency for *_, frequency in forces]))

    motion = integrate(system, columns, signals, end, round(end / 0.0025), round(step / 0.0025))
    return motion, 2.0 * np.tanh(motion.v[:, 2:] / 0.02)


@cache
def tabulated(forces):
    """The two-mass model at its forcing frequencies."""
    modes = tuple(range(len(forces)))
    reduced = rom.reduce(rom.two_mass(beta=0.01), modes)
    reduced = reduced.at_carrier(tuple(frequency for *_, frequency in forces))
    amplitude_range = (4.0, 2.0)[: len(forces)]
    return rom.tabulate(reduced, rom.Tanh(2.0, 0.02), amplitude_range, 1e-3, harmonics=5)


def rms_error(values, expected):
    return np.sqrt(np.mean((values - expected) ** 2) / np.mean(expected**2))


@pytest.mark.parametrize("step", [0.02, 0.5, 2.0])
def test_contact_motion_near_resonance_is_that_of_time_integration(step):
    """The bounds are those that the documentation of an FMU states."""
    motion, force = two_mass_motion(ALONE, 799.0, 0.02)
    stepped = fmu.Component(tabulated(ALONE), ({0: 1.0},), contact=True, elastic=(0,))
    stepped.set_inputs(force_A=0.15, frequency_A=0.9825)
    stepped.do_step(0.0, 751.0)
    rows = march(stepped, np.full(round(48.0 / step), step))
    at = np.rint(rows[:, 0] / 0.02).astype(int) - 1
    expected = {"x_0": (motion.x[at, 0], 1e-3)}
    for i in (0, 1):
        expected[f"contact_{i}_x"] = motion.x[at, 2 + i], 1e-3
        expected[f"contact_{i}_v"] = motion.v[at, 2 + i], 0.015
        expected[f"contact_{i}_f"] = force[at, i], 1e-3
    for name, (values, bound) in expected.items():
        found = rows[:, stepped.output_names.index(name)]
        assert rms_error(found, values) < bound, name


def test_two_modes_from_rest_are_within_the_stated_error_of_time_integration():
    motion, force = two_mass_motion(BOTH, 300.0, 0.5)
    of = tabulated(BOTH)
    stepped = component(of=of, contact=True, elastic=(0, 1))
    rows, stated = [], []
    for _ in range(600):
        rows.append(march(stepped, [0.5])[0])
        error = stepped.transient_error() + of.accuracy.total * np.abs(amplitude(stepped))
        stated.append(2.0 * np.abs(of.reduced.mode_shapes[:2]) @ error)
    columns = dict(zip(stepped.output_names, np.transpose(rows), strict=True))
    for j in (0, 1):
        error = np.abs(columns[f"x_{j}"] - motion.x[:, j]).max()
        assert error < np.max(stated, axis=0)[j] < 0.1 * np.abs(motion.x[:, j]).max()
        # the documentation: contact outputs omit about 1 %
        assert rms_error(columns[f"contact_{j}_x"], motion.x[:, 2 + j]) < 0.01
        assert rms_error(columns[f"contact_{j}_v"], motion.v[:, 2 + j]) < 0.015
        assert rms_error(columns[f"contact_{j}_f"], force[:, j]) < 0.01


def test_elastic_contacts_from_rest_are_within_the_stated_error_of_time_integration():
    """A cantilever with four Jenkins contacts, from rest and where it is steady."""
    law, steps, each = cantilever.LAWS["Jenkins"], 300, 216
    limit, stiffness = (np.array(values) for values in (law.limit, law.stiffness))
    of = cantilever.model("Jenkins", (0,), 1e-2)
    s, Omega = cantilever.cantilever(law), float(of.reduced.frequency[0])
    W = s.directions if isinstance(s.directions, np.ndarray) else s.directions.toarray()
    joints = [jenkins(*pair) for pair in zip(limit, stiffness, strict=True)]
    system = System(s.mass, s.damping, s.stiffness, W, joints)
    step = 1.35 * 2.0 * np.pi / Omega
    pattern = 0.05 * np.eye(24)[:, [cantilever.TIP]]
    end, count = steps * step, steps * each
    motion = integrate(system, pattern, lambda t: np.cos(Omega * t)[:, np.newaxis], end, count)
    at = slice(each - 1, None, each)

    patterns, slid, forces = cantilever.FORCE_PATTERNS[:1], np.zeros(4), []
    for x in motion.x @ W:  # Jenkins elements
        slid = np.clip(slid, x - limit / stiffness, x + limit / stiffness)
        forces.append(stiffness * (x - slid))
    forces = np.array(forces)[at]

    stepped = fmu.Component(of, patterns, contact=True, elastic=cantilever.DOFS)
    stepped.set_inputs(force_A=0.05, frequency_A=Omega)
    rows, stated = [], []
    for _ in range(steps):
        rows.append(march(stepped, [step])[0])
        stated.append(stepped.transient_error()[0])
    rows = np.array(rows)
    largest = np.hypot(rows[:, 1], rows[:, 2]).max()
    table = of.accuracy.total + of.accuracy.detuning
    transient = max(stated) / largest + table
    names = stepped.output_names
    for name, values in {f"x_{dof}": motion.x[at, dof] for dof in cantilever.DOFS}.items():
        found = rows[:, names.index(name)]
        assert np.abs(found - values).max() < transient * np.abs(values).max(), name
        assert rms_error(found[200:], values[200:]) < table, name
    moved = (motion.x @ W)[at][200:]
    bound = table * np.linalg.norm(moved, axis=0).max()
    for i in range(4):
        x, f = (rows[200:, names.index(f"contact_{i}_{quantity}")] for quantity in "xf")
        assert np.linalg.norm(x - moved[:, i]) < bound
        # a force error is the stiffness times the displacement errors now and at the reversal
        assert np.linalg.norm(f - forces[200:, i]) < 2.0 * stiffness[i] * bound


# Energy


def test_powers_are_those_of_time_integration():
    motion, force = two_mass_motion(ALONE, 799.0, 0.02)
    stepped = fmu.Component(tabulated(ALONE), ({0: 1.0},))
    stepped.set_inputs(force_A=0.15, frequency_A=0.9825)
    found = dict(zip(stepped.output_names, march(stepped, [799.0])[0], strict=True))
    last = slice(-round(7 * 2.0 * np.pi / 0.9825 / 0.02), None)  # whole periods
    given = 0.15 * np.cos(0.9825 * motion.t) * motion.v[:, 0]
    lost = np.sum(force * motion.v[:, 2:], axis=1)
    assert found["input_power"] == pytest.approx(np.mean(given[last]), rel=1e-3)
    assert found["dissipated_power"] == pytest.approx(np.mean(lost[last]), rel=5e-3)


@pytest.mark.parametrize("modes", [(0,), (0, 1)], ids=["one mode", "two modes"])
def test_in_steady_state_the_input_power_is_dissipated(modes):
    """By modal dampers, 2 gamma (omega |a|)^2, and by friction."""
    of = model_with_steady_states(modes, "paper")
    steady = component({"force_A": 0.05, "force_B": 0.2}, of)
    march(steady, [20000.0])
    now, a = steady.outputs(), amplitude(steady)[: of.modes]
    structural = np.sum(2.0 * of.reduced.modal_damping * (of.reduced.frequency * np.abs(a)) ** 2)
    assert now["dissipated_power"] > 0.1 * structural
    # power and S_j are interpolated each on its own, to the tolerance of the table
    assert now["input_power"] == pytest.approx(structural + now["dissipated_power"], rel=1e-3)


def test_dissipated_energy_is_the_integral_of_dissipated_power():
    rows = march(component(), np.full(4000, 0.05))
    names = component().output_names
    power, energy = (rows[:, names.index(f"dissipated_{name}")] for name in ("power", "energy"))
    assert power.max() > 0.1
    assert energy[-1] - energy[0] == pytest.approx(simpson(power, dx=0.05), rel=1e-6)


# Inputs that move


@pytest.mark.parametrize(
    ("ramped", "rate"), [("force_A", 2e-3), ("frequency_B", 3e-4), ("phase_A", 0.02)]
)
def test_a_staircase_tends_to_a_ramp_with_second_order(ramped, rate):
    paper, duration = model(formulation="paper"), 40.0  # no term in the rate of a sweep
    quantity, mode = ramped.split("_")

    def arrive(stairs):
        stepped = component(HELD, paper, tolerance=1e-10)
        stepped.reset(amplitude=(1.0 - 0.5j, 0.6 - 0.2j))
        if not stairs:
            stepped.set_inputs(**{f"{quantity}_rate_{mode}": rate})
            march(stepped, [duration])
        for k in range(stairs):
            middle = HELD.get(ramped, 0.0) + rate * duration * (k + 0.5) / stairs
            stepped.set_inputs(**{ramped: middle})
            march(stepped, [duration / stairs])
        return amplitude(stepped)

    coarse, fine = (np.abs(arrive(stairs) - arrive(0)).max() for stairs in (8, 16))
    assert 1e-7 < fine < 1e-2
    assert coarse / fine == pytest.approx(4.0, rel=0.1)
