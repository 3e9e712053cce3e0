"""The component's contract: steps, inputs, state, traces, refusals, the end of the table."""

from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from elastic import cantilever
from stepping import (
    FORCE_PATTERNS,
    HELD,
    STEPS,
    SWEPT,
    amplitude,
    component,
    march,
    model,
    state_of,
)

from slipmode import rom
from slipmode.fmu import Component, StoppedError
from slipmode.runner import shipped_scenes

pytestmark = pytest.mark.quick

NAN, INFINITE = float("nan"), float("inf")


def elastic_component(name="mixed", modes=(0, 1), scale=1.0, **inputs):
    """Of a cantilever, near its natural frequencies."""
    patterns = cantilever.FORCE_PATTERNS[: len(modes)]
    made = Component(
        cantilever.model(name, modes), patterns, contact=True, elastic=cantilever.DOFS
    )
    forces = {key: scale * force for key, force in cantilever.FORCES.items()}
    made.set_inputs(**{key: forces[key] for key in forces if key in made.input_names}, **inputs)
    return made


@cache
def tone_model():
    """Two modes of the shipped plate on one tone."""
    plate = rom.load_structure(shipped_scenes()["square-plate"].with_suffix(".npz"))
    law = rom.Jenkins(0.8, 1e4)
    return rom.tabulate(rom.reduce(plate, (1, 2), law=law, tones=(0, 0)), law)


def tone_component():
    made = Component(tone_model(), [{13: 1.0}], contact=True, elastic=(0, 13), warned=False)
    made.set_inputs(force_A=1.0, frequency_A=1725.0, phase_rate_A=0.1)
    return made


MADE = {
    "tone": tone_component,
    "slow": lambda: component(SWEPT),
    "contacts": lambda: component(SWEPT, contact=True, elastic=(0, 1)),
    "elastic contacts": elastic_component,
    "gap": lambda: elastic_component("with a gap"),
}
KINDS = [pytest.param(kind, marks=[pytest.mark.slow] if kind == "gap" else []) for kind in MADE]


def inputs_at_rest(made, steps, **values):
    """Inputs of steps, as `run` takes them."""
    natural = made.model.reduced.frequency
    given = {f"frequency_{mode}": w for mode, w in zip("AB", natural, strict=False)}
    given |= {"limit_scale": 1.0} | values
    return np.tile([given.get(name, 0.0) for name in made.input_names], (steps, 1))


# Steps and inputs


@pytest.mark.parametrize("pattern", [0.1, 10.0, "irregular"])
@pytest.mark.parametrize("inputs", [HELD, SWEPT], ids=["held", "swept"])
def test_one_long_step_equals_many_short_ones(pattern, inputs):
    if pattern == "irregular":
        durations = np.diff([0.0, *np.sort(np.random.default_rng(1).uniform(0, 200, 300)), 200.0])
    else:
        durations = np.full(round(200.0 / pattern), pattern)
    once, often = component(inputs, tolerance=1e-8), component(inputs, tolerance=1e-8)
    march(once, [200.0])
    march(often, durations)
    np.testing.assert_allclose(amplitude(often), amplitude(once), rtol=1e-6)
    long, short = once.outputs(), often.outputs()
    assert short["time"] == pytest.approx(200.0, rel=1e-14)
    assert short["dissipated_energy"] == pytest.approx(long["dissipated_energy"], rel=1e-6)
    for angle in ("theta_A", "theta_B"):
        assert np.exp(1j * short[angle]) == pytest.approx(np.exp(1j * long[angle]), abs=1e-9)


def test_contact_motion_hardly_depends_on_when_it_was_read_before():
    """By less than 1e-5 of its range; slow outputs have equal bits."""
    often, seldom = component(contact=True), component(contact=True)
    for _ in range(100):
        often.do_step(often.time, 1.0)
        seldom.do_step(seldom.time, 1.0)
        often.outputs()
    read, unread = often.outputs(), seldom.outputs()
    for name, value in read.items():
        exact = not name.startswith("contact")
        assert unread[name] == pytest.approx(value, abs=0.0 if exact else 2e-5, rel=0.0)


@pytest.mark.parametrize("kind", KINDS)
def test_run_has_the_bits_of_a_loop_of_steps(kind):
    rng, looped, at_once = np.random.default_rng(2), MADE[kind](), MADE[kind]()
    inputs = inputs_at_rest(looped, STEPS.size, force_B=0.05, frequency_rate_A=-1e-5)
    inputs[:, looped.input_names.index("force_A")] = rng.uniform(0.0, 0.05, STEPS.size)
    rows = []
    for row, duration in zip(inputs, STEPS, strict=True):
        looped.set_inputs(**dict(zip(looped.input_names, row.tolist(), strict=True)))
        rows.append(march(looped, [duration])[0])
    np.testing.assert_array_equal(at_once.run(STEPS, inputs), rows)
    assert state_of(at_once) == state_of(looped)


def test_without_a_pattern_the_input_is_the_modal_force():
    """phi_j . F, with modes of modal mass 1."""
    shapes = model().reduced.mode_shapes[[0, 1], [0, 1]]
    modal = Component(model())
    modal.set_inputs(**HELD | {"force_A": 0.15 * shapes[0], "force_B": 0.25 * shapes[1]})
    np.testing.assert_allclose(march(modal, [50.0]), march(component(), [50.0]), rtol=1e-12)


@pytest.mark.oracle
@pytest.mark.parametrize("modes", [(0,), (0, 1)], ids=["one mode", "two modes"])
def test_elastic_contacts_scale_with_their_loads(modes):
    """Motion times s, powers and energy times s^2; without rounding for powers of two."""
    one, scaled = elastic_component(modes=modes), elastic_component("mixed", modes, 4.0)
    scaled.set_inputs(limit_scale=4.0)
    durations = STEPS[:10]
    expected, rows = march(one, durations), march(scaled, durations)
    for k, output in enumerate(one.output_names):
        power = output.endswith(("power", "energy"))
        factor = 1.0 if output.startswith(("time", "theta")) else 16.0 if power else 4.0
        np.testing.assert_array_equal(rows[:, k] / factor, expected[:, k], err_msg=output)


# State


@pytest.mark.parametrize("kind", KINDS)
def test_a_state_continues_bit_for_bit(kind):
    first = MADE[kind]()
    march(first, STEPS)
    state = first.get_state()
    expected = march(first, STEPS)
    for continued in (first, MADE[kind]()):
        continued.set_state(state)
        np.testing.assert_array_equal(march(continued, STEPS), expected)
        assert state_of(continued) == state_of(first)


def test_reset_forgets_all_but_the_inputs():
    used, fresh = component(contact=True), component(contact=True)
    march(used, STEPS)
    for restarted in (used, fresh):
        restarted.reset(time=3.0, amplitude=(0.5j, -0.2))
    np.testing.assert_array_equal(amplitude(used), [0.5j, -0.2])
    np.testing.assert_array_equal(march(used, STEPS), march(fresh, STEPS))


def test_components_in_threads_do_not_disturb_each_other():
    inputs = [HELD, SWEPT, HELD | {"force_A": 0.02}]
    alone = [march(component(given, contact=True), STEPS) for given in inputs]
    together = [component(given, contact=True) for given in inputs]
    with ThreadPoolExecutor(len(together)) as pool:
        rows = list(pool.map(march, together, [STEPS] * len(together)))
    np.testing.assert_array_equal(rows, alone)


@pytest.mark.parametrize(("name", "number"), [("A", 0), ("B", 1)])
def test_a_mode_that_is_not_modelled_has_no_inputs_and_reads_zero(name, number):
    alone = Component(model((number,)), FORCE_PATTERNS[number : number + 1], mode_names=(name,))
    assert {variable[-1] for variable in alone.input_names} == {name}
    alone.set_inputs(**{f"force_{name}": HELD[f"force_{name}"]})
    march(alone, [50.0])
    assert (np.abs(amplitude(alone)) > 0.0).tolist() == [name == "A", name == "B"]


# Traces

LENGTHS = np.array([50.0, 0.2, 3000.0, 400.0])


def scripted(traced, force):
    """Inputs of steps of LENGTHS: a jump, a ramp, a sweep."""
    inputs = np.tile([HELD.get(name, 0.0) for name in traced.input_names], (LENGTHS.size, 1))
    inputs[2:, traced.input_names.index("force_A")] = force
    inputs[2, traced.input_names.index("frequency_rate_A")] = 2e-6
    inputs[3, traced.input_names.index("force_rate_B")] = -2e-4
    return inputs


def test_a_trace_passes_through_the_outputs_of_a_run_and_rests_where_nothing_happens():
    traced, run = (component({}, contact=True, tolerance=1e-8) for _ in range(2))
    inputs = scripted(traced, 0.05)
    found = np.concatenate(list(traced.trace(LENGTHS, inputs)))
    ends = np.searchsorted(found[:, 0], np.cumsum(LENGTHS) * (1 - 1e-12))
    np.testing.assert_allclose(found[ends, 0], np.cumsum(LENGTHS), rtol=1e-13)
    np.testing.assert_allclose(found[ends, 1:5], run.run(LENGTHS, inputs)[:, 1:5], atol=1e-6)
    assert ends[-1] == len(found) - 1
    busy = found[:, 0] < 200.0
    assert 0.0 < np.diff(found[busy, 0]).max() < np.diff(found[:, 0]).max()


def test_a_trace_that_leaves_the_table_goes_up_to_its_edge():
    traced, rows = component({}), []
    with pytest.raises(StoppedError, match=r"amplitude \|A\| leaves the friction table") as stop:
        rows.extend(traced.trace(LENGTHS, scripted(traced, 0.3)))
    last = np.concatenate((*rows, stop.value.outputs))[-1]
    assert stop.value.left_table
    assert np.hypot(*last[1:3]) == pytest.approx(traced.model.table.amplitude_range[0], rel=1e-3)
    assert traced.time == last[0] == stop.value.time


# Refusals and stops: the component is as before

REFUSED = [
    (lambda c: c.set_inputs(forse_A=1.0), "forse_A: is not an input; inputs are force_A"),
    (lambda c: c.set_inputs(phase_rate_B=INFINITE), "phase_rate_B: must be finite"),
    (lambda c: c.set_inputs(force_A=1.0, frequency_B=0.0), "frequency_B: must be 1.06 to 17"),
    (lambda c: c.set_inputs(limit_scale=1.0), "limit_scale: the contact law has a velocity alpha"),
    (lambda c: c.do_step(c.time + 1.0, 1.0), "time: must be the present time of the component"),
    (lambda c: c.do_step(c.time, 0.0), "step: must be finite and > 0 s"),
    (lambda c: c.do_step(c.time, 1e5), "frequency_A: must be 0.62 .* at the end of the step"),
    (lambda c: c.run([1.0], np.full((1, 12), NAN)), "force_A: must be finite"),
    (lambda c: c.run([1.0], np.zeros((1, 3))), r"inputs: must have shape \(1, 12\)"),
    (lambda c: c.reset(amplitude=(0.0, 9.0)), "amplitude: .* outside the friction table"),
    (lambda c: c.reset(amplitude=(0.1, 0.1, 0.1)), "amplitude: must be at most 2 numbers"),
    (lambda c: c.set_state(np.zeros(3)), "state: must have"),
    (lambda c: Component(c.model, contact=True, elastic=(0, 4)), "elastic: DOFs must be 0 to 3"),
    (lambda c: Component(c.model, elastic=(0,)), "elastic: needs contact=True"),
    (lambda c: Component(c.model, ({0: 1.0},)), "force_patterns: needs one entry per mode"),
    (lambda c: Component(c.model, mode_names=("A", "C")), "mode_names: must have 2 different"),
    (lambda c: Component(bare_model(), contact=True), "contact: .* with harmonics=5"),
]


def bare_model():
    """Without harmonics."""
    return rom.tabulate(rom.reduce(rom.two_mass(), (0,)), rom.Tanh(2.0, 0.02), (1.0,), 1e-2)


@pytest.mark.parametrize(("call", "complaint"), REFUSED)
def test_refusals_are_one_line_that_names_the_variable_and_change_nothing(call, complaint):
    stepped = component(HELD | {"frequency_rate_A": -1e-4}, contact=True)
    march(stepped, [1.5, 2.0])
    before = state_of(stepped)
    with pytest.raises(rom.SlipmodeError, match=complaint) as refusal:
        call(stepped)
    assert "\n" not in str(refusal.value)
    assert state_of(stepped) == before


@pytest.mark.parametrize("mode", ["A", "B"])
def test_a_step_out_of_the_table_says_when_and_leaves_the_state(mode):
    strong = component(contact=True)
    march(strong, [10.0])
    strong.set_inputs(**{f"force_{mode}": 5.0})
    before = state_of(strong)
    with pytest.raises(StoppedError, match=rf"stopped at t = 10 s: amplitude \|{mode}\|") as stop:
        strong.do_step(10.0, 500.0)
    assert state_of(strong) == before
    leaves = float(str(stop.value).split("at t = ")[2].split(" s; ")[0])
    strong.do_step(10.0, leaves - 10.0 - 1e-3)
    limit = strong.model.table.amplitude_range["AB".index(mode)]
    assert np.abs(amplitude(strong))["AB".index(mode)] == pytest.approx(limit, rel=1e-2)


def test_a_run_that_stops_keeps_the_steps_that_succeeded():
    stopped, looped = component(), component()
    inputs = np.tile([HELD.get(name, 0.0) for name in stopped.input_names], (6, 1))
    inputs[4:, stopped.input_names.index("force_A")] = 50.0
    with pytest.raises(StoppedError) as stop:
        stopped.run(np.full(6, 20.0), inputs)
    np.testing.assert_array_equal(stop.value.outputs, march(looped, np.full(4, 20.0)))
    assert stop.value.time == stopped.time == 80.0
    np.testing.assert_array_equal(march(stopped, STEPS), march(looped, STEPS))


def test_the_range_of_amplitudes_scales_with_the_friction_limits(coulomb_model):
    scaled = Component(coulomb_model, FORCE_PATTERNS)
    for scale, inside, outside in ((0.5, 1.45, 1.55), (2.0, 5.9, 6.1)):
        scaled.set_inputs(limit_scale=scale)
        scaled.reset(amplitude=(inside, 0.0))
        with pytest.raises(rom.SlipmodeError, match="outside the friction table, which ends at"):
            scaled.reset(amplitude=(outside, 0.0))
    for wrong in (0.0, NAN):
        with pytest.raises(rom.SlipmodeError, match="limit_scale: must be"):
            scaled.set_inputs(limit_scale=wrong)
