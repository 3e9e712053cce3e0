"""Components of modes that share a tone: outputs, states, inputs that jump and move."""

import numpy as np
import pytest

from slipmode import fmu, rom, runner

PLATE = rom.load_structure(runner.shipped_scenes()["square-plate"].with_suffix(".npz"))
LAW, FORCE = rom.Jenkins(0.8, 1e4), {13: 1.0}


@pytest.fixture(scope="module")
def model():
    reduced = rom.reduce(PLATE, (1, 2), law=LAW, tones=(0, 0))
    return rom.tabulate(reduced, LAW)


def component(model, **options):
    return fmu.Component(model, [FORCE], warned=False, **options)


def test_outputs_are_those_of_the_flow(model):
    made = component(model, contact=True, elastic=(10, 13), tolerance=model.tolerance)
    flow = rom.tone_flow(model, model.middle, FORCE)
    inputs = {"force": 0.7, "frequency": 1730.0, "phase": 0.4}
    made.set_inputs(**{f"{name}_A": value for name, value in inputs.items()})
    flow.step(0.0, magnitude=0.7, frequency=1730.0, phase=0.4)
    made.set_inputs(frequency_rate_A=50.0, phase_rate_A=-2.0)
    made.do_step(0.0, 0.3)
    flow.step(0.3, frequency=1745.0, phase=-0.2)
    found, turn = made.outputs(), np.exp(1j * flow.angle)
    amplitude = [found["A_re"] + 1j * found["A_im"], found["A2_re"] + 1j * found["A2_im"]]
    np.testing.assert_allclose(amplitude, flow.modal_amplitude()[:2], rtol=1e-9)
    moved = 2.0 * (flow.displacement() * turn).real
    found_x = [found[name] for name in ("x_10", "x_13", "contact_0_x")]
    np.testing.assert_allclose(found_x, moved[[10, 13, 10]], rtol=1e-5)
    assert found["theta_A"] == pytest.approx(flow.angle, abs=1e-9)


@pytest.mark.oracle
def test_the_work_of_the_force_is_dissipated(model):
    """In a steady state, by the contact and by the damping of all modes, which move by the force
    and by the contact; it is the amplitude that rom.steady has."""
    made = component(model, tolerance=1e-8)
    made.set_inputs(force_A=1.0, frequency_A=1725.0)
    made.do_step(0.0, 6.0)
    before, energy = made.time, made.outputs()["dissipated_energy"]
    made.do_step(before, 0.5)
    found, a = made.outputs(), rom.steady(model, [1725.0], [FORCE])
    amplitude = np.array(
        [found["A_re"] + 1j * found["A_im"], found["A2_re"] + 1j * found["A2_im"]]
    )
    np.testing.assert_allclose(amplitude, a, rtol=1e-3)
    power = found["dissipated_power"]
    assert found["dissipated_energy"] - energy == pytest.approx(0.5 * power, rel=1e-4)
    structural = 2.0 * 1725.0**2 * model.reduced.modal_damping @ np.abs(amplitude) ** 2
    assert found["input_power"] == pytest.approx(power + structural, rel=2e-3)
    assert power > 0.1 * found["input_power"]


def test_a_state_restores_every_bit_and_a_run_is_a_loop_of_steps(model):
    made, other = component(model, contact=True), component(model, contact=True)
    durations = np.full(20, 0.013)
    rows = np.zeros((20, len(made.input_names)))
    rows[:, list(made.input_names).index("force_A")] = np.linspace(0.2, 1.0, 20)
    rows[:, list(made.input_names).index("frequency_A")] = np.linspace(1700.0, 1760.0, 20)
    rows[:, list(made.input_names).index("limit_scale")] = 1.1
    outputs = made.run(durations, rows)
    for k, row in enumerate(rows):
        if k == 10:
            middle = other.get_state()
        other.set_inputs(**dict(zip(made.input_names, row.tolist(), strict=True)))
        other.do_step(other.time, 0.013)
        assert list(other.outputs().values()) == outputs[k].tolist()
    other.set_state(middle)
    assert np.array_equal(other.run(durations[10:], rows[10:]), outputs[10:])
    made.reset()
    assert made.time == 0.0 and np.array_equal(made.run(durations, rows), outputs)


@pytest.mark.oracle
def test_displacements_are_continuous_where_inputs_jump(model):
    made = component(model, contact=True, elastic=(0, 10))
    made.set_inputs(force_A=1.0, frequency_A=1725.0)
    made.do_step(0.0, 0.4)
    before = made.outputs()
    made.set_inputs(force_A=-0.5, phase_A=2.0)
    after = made.outputs()
    largest = abs(before["x_10"])
    for name in ("x_10", "x_0", "contact_0_x"):
        assert abs(after[name] - before[name]) < 3e-3 * largest
    made.set_inputs(force_A=1.0, phase_A=0.0)
    assert made.outputs()["A2_re"] == pytest.approx(before["A2_re"], rel=1e-9)


def test_limits_scale_as_forces_do(model):
    strong, weak = component(model), component(model)
    strong.set_inputs(force_A=2.0, limit_scale=2.0)
    weak.set_inputs(force_A=1.0)
    for each in (strong, weak):
        each.do_step(0.0, 0.5)
    assert strong.outputs()["A_im"] == pytest.approx(2.0 * weak.outputs()["A_im"], rel=1e-9)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c: c.set_inputs(force_B=1.0), "force_B: is not an input"),
        (lambda c: c.set_inputs(frequency_A=1500.0), "frequency_A: must be within 10 % of"),
        (lambda c: c.reset(amplitude=[1e-5]), "amplitude, time: must be 0 and finite"),
        (lambda c: c.set_amplitude([0.0]), "set_amplitude: is not available"),
        (lambda c: c.transient_error(), "transient_error: is not available"),
        (lambda c: list(c.trace(np.ones(1), np.ones((1, 8)))), "trace: is not available"),
    ],
)
def test_what_a_tone_does_not_have_is_refused(model, call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(component(model))
    with pytest.raises(rom.SlipmodeError, match="force: needs one entry"):
        fmu.Component(model, [FORCE, FORCE])
