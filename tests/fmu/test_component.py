"""The step-able component: its steps, inputs, state, energy and refusals."""

import re
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp
from slow_time import slow_trajectory, steady_balance
from stepping import (
    FORCE_PATTERNS,
    HELD,
    STEPS,
    SWEPT,
    amplitude,
    component,
    march,
    model,
    model_with_steady_states,
    state_of,
)

from slipmode import rom
from slipmode.fmu import Component, StoppedError
from slipmode.rom import reconstruct
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.slow.slow_flow import inputs_of, rates, slow_flow

pytestmark = pytest.mark.quick

# Steps


@pytest.mark.parametrize("step", [0.01, 0.1, 1.0, 10.0, 100.0, "irregular"])
@pytest.mark.parametrize("inputs", [HELD, SWEPT], ids=["held", "swept"])
def test_one_long_step_equals_many_short_ones(step, inputs):
    end = 200.0
    if step == "irregular":
        points = np.sort(np.random.default_rng(1).uniform(0.0, end, 300))
        durations = np.diff([0.0, *points, end])
    else:
        durations = np.full(round(end / step), step)
    once, often = component(inputs, tolerance=1e-8), component(inputs, tolerance=1e-8)
    march(once, [end])
    march(often, durations)
    assert often.time == pytest.approx(end, rel=1e-14)
    np.testing.assert_allclose(amplitude(often), amplitude(once), rtol=1e-6)
    long, short = once.outputs(), often.outputs()
    assert short["dissipated_energy"] == pytest.approx(long["dissipated_energy"], rel=1e-6)
    for angle in ("theta_A", "theta_B"):
        assert np.exp(1j * short[angle]) == pytest.approx(np.exp(1j * long[angle]), abs=1e-9)


@pytest.mark.parametrize("contact", [False, True])
def test_run_equals_a_loop_of_steps(contact):
    rng = np.random.default_rng(2)
    looped, at_once = component(contact=contact), component(contact=contact)
    names = looped.input_names
    inputs = np.tile([SWEPT.get(name, 0.0) for name in names], (STEPS.size, 1))
    inputs[:, names.index("force_A")] = rng.uniform(0.0, 0.2, STEPS.size)
    rows = []
    for row, duration in zip(inputs, STEPS, strict=True):
        looped.set_inputs(**dict(zip(names, row, strict=True)))
        rows.append(march(looped, [duration])[0])
    np.testing.assert_array_equal(at_once.run(STEPS, inputs), rows)
    assert state_of(at_once) == state_of(looped)


def test_no_steps_change_nothing():
    still = component()
    before = state_of(still)
    assert still.run(np.empty(0), np.empty((0, 12))).shape == (0, len(still.output_names))
    assert state_of(still) == before


# Inputs


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


def test_a_swept_step_solves_the_slow_flow():
    of = model_with_steady_states()
    force, frequency = np.array([0.15, 0.25]), np.array([0.98, 1.65])
    rate = np.array([-1e-4, 2e-4])

    equations = slow_flow(of)

    def flow(time, a):
        moved = (frequency + rate * time)[np.newaxis]
        inputs = inputs_of(force[np.newaxis].astype(complex), moved, frequency_rate=rate)
        return rates(equations, inputs, a[np.newaxis])[0]

    exact = solve_ivp(flow, (0.0, 100.0), np.zeros(2, complex), rtol=1e-10, atol=1e-12).y[:, -1]
    swept = component(HELD | {"frequency_rate_A": rate[0], "frequency_rate_B": rate[1]}, of)
    march(swept, [100.0])
    np.testing.assert_allclose(amplitude(swept), exact, rtol=1e-5)


def test_inputs_hold_and_move_on_until_they_are_set_again():
    of = model_with_steady_states()
    swept = component(HELD | {"phase_rate_A": 0.5, "frequency_rate_A": 1e-3}, of)
    march(swept, [2.0, 3.0])
    swept.set_inputs(phase_rate_A=0.0)
    moved = {"phase_A": 2.5, "frequency_A": 0.985, "frequency_rate_A": 1e-3}
    explicit = component(HELD | moved, of)
    explicit.reset(swept.time, amplitude(swept))
    march(swept, [10.0])
    march(explicit, [10.0])
    np.testing.assert_allclose(amplitude(swept), amplitude(explicit), rtol=1e-4)


def test_without_a_pattern_the_input_is_the_modal_force():
    shapes = model().reduced.mode_shapes[[0, 1], [0, 1]]
    modal = Component(model())
    modal.set_inputs(**HELD | {"force_A": 0.15 * shapes[0], "force_B": 0.25 * shapes[1]})
    physical = component()
    np.testing.assert_allclose(march(modal, [50.0]), march(physical, [50.0]), rtol=1e-12)


# Friction limits

WEAK = {"force_A": 0.1, "force_B": 0.15}


@cache
def coulomb_model(limit, amplitude):
    reduced = rom.reduce(rom.two_mass(beta=0.01), formulation="paper")
    return rom.tabulate(reduced, rom.Coulomb(limit), (amplitude, 0.5 * amplitude), tolerance=5e-3)


@pytest.mark.parametrize("scale", [0.6, 1.5])
def test_scaled_limits_are_those_of_a_model_tabulated_with_them(scale, monkeypatch):
    """S(s |A|, s |B|; s mu N) = s S(|A|, |B|; mu N) for Coulomb friction, and s^2 for powers."""
    monkeypatch.setattr(
        "slipmode.fmu.handle.STEPS_PER_PERIOD", 256
    )  # a velocity may be near a corner
    held = HELD | WEAK
    scaled = component(held | {"limit_scale": scale}, coulomb_model(2.0, 4.0), contact=True)
    tabulated = component(held, coulomb_model(2.0 * scale, 4.0 * scale), contact=True)
    unscaled = component(held, coulomb_model(2.0, 4.0), contact=True)
    names = scaled.output_names
    columns = [k for k, name in enumerate(names) if not name.startswith("theta")]
    rows, expected, others = (
        march(each, np.full(30, 10.0))[:, columns] for each in (scaled, tabulated, unscaled)
    )
    largest = np.abs(expected).max(axis=0)
    largest[largest < 1e-6] = 1.0  # a contact that sticks
    # of both tables; of the march, where a stick begins: measured 0.7 %
    bound = np.where(["contact" in names[k] for k in columns], 1e-2, 3e-3)
    assert (np.abs(rows - expected) <= bound * largest).all()
    assert np.abs((others - expected) / largest).max() > 0.1


def test_limits_that_fall_steadily_pass_through_all_the_scales_between():
    of, stairs = coulomb_model(2.0, 4.0), 400  # no term in the rate of the scale
    ramped, stepped = component(HELD | WEAK, of), component(HELD | WEAK, of)
    ramped.set_inputs(limit_scale_rate=-0.002)
    march(ramped, [200.0])
    for k in range(stairs):
        stepped.set_inputs(limit_scale=1.0 - 0.4 * (k + 0.5) / stairs)
        march(stepped, [200.0 / stairs])
    np.testing.assert_allclose(amplitude(ramped), amplitude(stepped), rtol=1e-5)


def test_the_table_ends_where_the_scaled_amplitude_does():
    small = component({"limit_scale": 0.5}, coulomb_model(2.0, 4.0))
    small.reset(amplitude=(1.9, 0.0))
    with pytest.raises(
        rom.SlipmodeError,
        match=r"mode A reaches 2.1 .* outside the friction table, which ends at 2 ",
    ):
        small.reset(amplitude=(2.1, 0.0))
    small.set_inputs(limit_scale=2.0)
    small.reset(amplitude=(7.9, 0.0))


@pytest.mark.parametrize(
    ("coulomb", "values", "complaint"),
    [
        (False, {"limit_scale": 1.0}, "limit_scale: the contact law has a velocity alpha"),
        (True, {"limit_scale": 0.0}, "limit_scale: must be > 0"),
        (True, {"limit_scale": float("nan")}, "limit_scale: must be finite"),
    ],
)
def test_limits_that_cannot_be_scaled(coulomb, values, complaint):
    of = coulomb_model(2.0, 4.0) if coulomb else model()
    with pytest.raises(rom.SlipmodeError, match=complaint):
        component(of=of).set_inputs(**values)


# State


@pytest.mark.parametrize("contact", [False, True])
@pytest.mark.parametrize("elsewhere", [False, True], ids=["same instance", "other instance"])
def test_a_state_continues_bit_for_bit(contact, elsewhere):
    options = {"contact": contact, "elastic": (0, 1) if contact else ()}
    first = component(SWEPT, **options)
    march(first, STEPS)
    state = first.get_state()
    expected = march(first, STEPS)
    other = component({}, **options) if elsewhere else first
    other.set_state(state)
    np.testing.assert_array_equal(march(other, STEPS), expected)
    assert state_of(other) == state_of(first)


@pytest.mark.parametrize("contact", [False, True])
def test_reset_forgets_all_but_the_inputs(contact):
    used, fresh = component(contact=contact), component(contact=contact)
    march(used, STEPS)
    for restarted in (used, fresh):
        restarted.reset(time=3.0, amplitude=(0.5j, -0.2))
    assert used.time == 3.0
    np.testing.assert_array_equal(amplitude(used), [0.5j, -0.2])
    np.testing.assert_array_equal(march(used, STEPS), march(fresh, STEPS))


@pytest.mark.parametrize("threads", [False, True], ids=["interleaved", "threads"])
def test_instances_do_not_disturb_each_other(threads):
    inputs = [HELD, SWEPT, HELD | {"force_A": 0.02}]
    alone = [march(component(given, contact=True), STEPS) for given in inputs]
    together = [component(given, contact=True) for given in inputs]
    if threads:
        with ThreadPoolExecutor(len(together)) as pool:
            rows = list(pool.map(march, together, [STEPS] * len(together)))
    else:
        turns = [[march(each, [step])[0] for each in together] for step in STEPS]
        rows = list(np.swapaxes(turns, 0, 1))
    np.testing.assert_array_equal(rows, alone)


# Energy


def test_dissipated_energy_is_the_integral_of_dissipated_power():
    rows = march(component(), np.full(4000, 0.05))
    names = component().output_names
    power, energy = (rows[:, names.index(f"dissipated_{name}")] for name in ("power", "energy"))
    assert power.max() > 0.1
    assert energy[-1] - energy[0] == pytest.approx(simpson(power, dx=0.05), rel=1e-6)


@pytest.mark.parametrize("formulation", ["consistent", "paper"])
@pytest.mark.parametrize("modes", [(0,), (0, 1)], ids=["one mode", "two modes"])
def test_in_steady_state_what_goes_in_leaves(modes, formulation):
    of = model_with_steady_states(modes, formulation)
    steady = component(of=of)
    march(steady, [20000.0])
    now = steady.outputs()
    forced = np.array([HELD["frequency_A"], HELD["frequency_B"]][: of.modes])
    turned = of.reduced.frequency if formulation == "paper" else forced
    a = amplitude(steady)[: of.modes]
    structural = np.sum(2.0 * of.reduced.modal_damping * turned * forced * np.abs(a) ** 2)
    friction = steady_balance(of, a, forced, np.zeros(of.modes)).friction[0]
    contacts = -np.sum(2.0 * forced * np.imag(a.conj() * friction))
    assert 0.1 * now["input_power"] < structural < 0.9 * now["input_power"]
    assert now["input_power"] == pytest.approx(structural + contacts, rel=1e-5)
    march(steady, [100.0])
    gained = steady.outputs()["dissipated_energy"] - now["dissipated_energy"]
    assert gained == pytest.approx(100.0 * now["dissipated_power"], rel=1e-5)


@pytest.mark.parametrize("modes", [(0,), (0, 1)], ids=["one mode", "two modes"])
def test_without_dampers_what_leaves_the_modes_is_dissipated(modes):
    """At the carriers of the table, where the friction power is known."""
    of = model(modes, "paper")
    steady = component({"force_A": 0.05, "force_B": 0.2}, of)
    march(steady, [20000.0])
    now, a = steady.outputs(), amplitude(steady)[: of.modes]
    structural = np.sum(2.0 * of.reduced.modal_damping * (of.reduced.frequency * np.abs(a)) ** 2)
    assert now["dissipated_power"] > 0.1 * structural
    # power and S_j are interpolated each on their own: the table's 1e-3
    assert now["input_power"] == pytest.approx(structural + now["dissipated_power"], rel=1e-3)


def test_the_dissipated_power_is_that_of_friction_alone():
    """The dampers that the contacts share with the modes have their part as well."""
    reduced = rom.reduce(rom.two_mass(beta=0.01), carrier=(0.98, 1.65))
    of = rom.tabulate(
        reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), 1e-3, combinations=(), harmonics=RESPONSE_ORDER
    )
    durations, held = np.full(2200, 1.0), component(of=of)
    rows = march(held, durations)
    trajectory = slow_trajectory(of, FORCE_PATTERNS, np.append(0.0, np.cumsum(durations)), **HELD)
    times = 2000.0 + np.arange(1, 16001) * 0.0125  # about as good as whole periods of both
    motion = reconstruct(of, trajectory, times, steps_per_period=256)
    friction = np.mean(np.sum(motion.force * motion.velocity, axis=1))
    power = rows[2000:, held.output_names.index("dissipated_power")].mean()
    # measured 0.34 %: the power takes no account of contact damping above the fifth harmonics
    assert power == pytest.approx(friction, rel=3.8e-3)


# One mode


@pytest.mark.parametrize(("name", "number"), [("A", 0), ("B", 1)])
def test_a_mode_that_is_not_modelled_has_no_inputs_and_reads_zero(name, number):
    alone = Component(model((number,)), FORCE_PATTERNS[number : number + 1], mode_names=(name,))
    assert {variable[-1] for variable in alone.input_names} == {name}
    alone.set_inputs(**{f"force_{name}": HELD[f"force_{name}"]})
    march(alone, [50.0])
    moving = np.abs(amplitude(alone)) > 0.0
    assert moving.tolist() == [name == "A", name == "B"]
    assert (alone.outputs()["theta_A"] > 0.0) == (name == "A")


# Refusals

INFINITE = float("inf")
NAN = float("nan")


@pytest.mark.parametrize(
    ("refused", "complaint"),
    [
        (lambda c: c.set_inputs(forse_A=1.0), "forse_A: is not an input; inputs are force_A"),
        (lambda c: c.set_inputs(force_A=NAN), "force_A: must be finite"),
        (lambda c: c.set_inputs(phase_rate_B=INFINITE), "phase_rate_B: must be finite"),
        (
            lambda c: c.set_inputs(force_A=1.0, frequency_B=0.0),
            "frequency_B: must be 1.06 to 17 rad/s",
        ),
        (lambda c: c.set_inputs(frequency_A=-1.0), "frequency_A: must be 0.62 to 10 rad/s"),
        (
            lambda c: c.do_step(c.time + 1.0, 1.0),
            "time: must be the present time of the component, 3.5 s",
        ),
        (lambda c: c.do_step(NAN, 1.0), "time: must be the present time of"),
        (lambda c: c.do_step(c.time, 0.0), "step: must be finite and > 0 s"),
        (lambda c: c.do_step(c.time, -1.0), "step: must be finite and > 0 s"),
        (lambda c: c.do_step(c.time, NAN), "step: must be finite and > 0 s"),
        (lambda c: c.do_step(c.time, INFINITE), "step: must be finite and > 0 s"),
        (lambda c: c.do_step(c.time, 1e5), r"frequency_A: must be 0.62 .* at the end of the step"),
        (lambda c: c.run([1.0], np.full((1, 12), NAN)), "force_A: must be finite"),
        (lambda c: c.run([1.0], np.zeros((1, 12))), "frequency_A: must be 0.62"),
        (lambda c: c.run([1.0], np.zeros((1, 3))), r"inputs: must have shape \(1, 12\)"),
        (lambda c: c.reset(time=NAN), "time: must be finite"),
        (lambda c: c.reset(amplitude=(NAN, 0.0)), "amplitude: must be finite"),
        (lambda c: c.reset(amplitude=(0.0, 9.0)), "amplitude: .* outside the friction table"),
        (lambda c: c.reset(amplitude=(0.1, 0.1, 0.1)), "amplitude: must be at most 2 numbers"),
        (lambda c: c.set_state(np.zeros(3)), "state: must have"),
        (lambda c: c.set_state(NAN * c.get_state()), "state: must be finite"),
    ],
)
def test_refusals_name_the_variable_and_change_nothing(refused, complaint):
    stepped = component(HELD | {"frequency_rate_A": -1e-4}, contact=True)
    march(stepped, [1.5, 2.0])
    before = state_of(stepped)
    with pytest.raises(rom.SlipmodeError, match=complaint) as refusal:
        refused(stepped)
    assert "\n" not in str(refusal.value)
    assert state_of(stepped) == before


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"contact": True, "elastic": (0, 4)}, r"elastic: DOFs must be 0 to 3, got \[0, 4\]"),
        ({"contact": True, "elastic": (-1,)}, "elastic: DOFs must be 0 to 3"),
        ({"elastic": (0,)}, "elastic: needs contact=True"),
        ({"tolerance": 0.0}, "tolerance: must be 1e-13 to 1e-2"),
        ({"tolerance": NAN}, "tolerance: must be 1e-13 to 1e-2"),
        ({"force_patterns": ({0: 1.0},)}, r"force_patterns: needs one entry per mode \(2\)"),
        ({"force_patterns": ({0: 1.0}, {7: 1.0})}, "force_patterns: DOF 7 is out of range"),
        ({"force_patterns": ({0: 1.0}, {0: NAN})}, "force_patterns: must be 4 finite numbers"),
        ({"mode_names": ("A",)}, "mode_names: must have 2 different names"),
        ({"mode_names": ("A", "C")}, "mode_names: must have 2 different names"),
    ],
)
def test_a_component_that_cannot_be_made(options, complaint):
    with pytest.raises(rom.SlipmodeError, match=complaint):
        Component(model(), **options)


@pytest.mark.parametrize("mode", ["A", "B"])
def test_a_step_out_of_the_table_says_so_and_leaves_the_state(mode):
    strong = component(contact=True)
    march(strong, [10.0])
    strong.set_inputs(**{f"force_{mode}": 5.0})
    before = state_of(strong)
    with pytest.raises(StoppedError, match=rf"stopped at t = 10 s: amplitude \|{mode}\|") as stop:
        strong.do_step(10.0, 500.0)
    assert stop.value.time == 10.0
    assert state_of(strong) == before
    leaves = float(re.search(r"at t = ([\d.]+) s; ", str(stop.value))[1])
    strong.do_step(10.0, leaves - 10.0 - 1e-3)
    limit = strong.model.table.amplitude_range["AB".index(mode)]
    assert np.abs(amplitude(strong))["AB".index(mode)] == pytest.approx(limit, rel=1e-2)
    strong.set_state(np.array(before[0]))
    strong.set_inputs(**HELD)
    reference = component(contact=True)
    np.testing.assert_array_equal(march(strong, [10.0]), march(reference, [10.0, 10.0])[1:])


def test_a_run_that_stops_keeps_the_steps_that_succeeded():
    stopped, looped = component(), component()
    names = stopped.input_names
    inputs = np.tile([HELD.get(name, 0.0) for name in names], (6, 1))
    inputs[4:, names.index("force_A")] = 50.0
    with pytest.raises(StoppedError) as stop:
        stopped.run(np.full(6, 20.0), inputs)
    np.testing.assert_array_equal(stop.value.outputs, march(looped, np.full(4, 20.0)))
    assert stop.value.time == stopped.time == 80.0
    np.testing.assert_array_equal(march(stopped, STEPS), march(looped, STEPS))
