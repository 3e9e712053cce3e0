"""Components and FMUs after a call that fails: as before it, or as far as they say."""

import shutil
import warnings

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmu_fixtures import FORCE_PATTERNS, START, VERSIONS, instance

from slipmode import fmu, rom

NAMES = ("A_re", "A_im", "B_re", "B_im", "theta_A", "dissipated_energy")


@pytest.mark.parametrize("fmi", VERSIONS)
def test_parameters_that_are_refused_do_not_restart_an_fmu(scalable, fmi):
    """The amplitudes are outside the table at this friction limit, so damping cannot change."""
    with instance(scalable[fmi], fmi) as made, instance(scalable[fmi], fmi) as twin:
        for each in (made, twin):
            each.start(**START).step(0.0, 10.0)
        made.set(limit_scale=1e-3)
        with pytest.raises(FMICallException):
            made.set(damping_A=0.05)
        assert "outside the friction table" in made.messages[-1][1]
        made.set(limit_scale=1.0)
        for each in (made, twin):
            each.step(10.0, 5.0)
        np.testing.assert_array_equal(made.get(*NAMES), twin.get(*NAMES))


@pytest.mark.parametrize("fmi", VERSIONS)
def test_inputs_that_overflow_are_no_state_of_an_fmu(tmp_path, fmi):
    """A force of 1e306 N times a pattern of 1e3 is not a number."""
    model = rom.model_of_rates(lambda r: (0.5 + 0 * r, 100.0 + 0 * r), amplitude=[0.1])
    path = fmu.export(model, tmp_path / "m.fmu", [{0: 1e3}], fmi=fmi, mode_names=("A",))
    shutil.unpack_archive(path, tmp_path / "m", format="zip")
    with instance(tmp_path / "m", fmi) as made:
        made.start(force_A=0.0).step(0.0, 1.0)
        made.set(force_A=1e306)
        with pytest.raises(FMICallException):
            made.serialize()
        assert made.messages[-1][1].startswith("inputs at t = 1 s: a value is NaN or infinite")
        made.set(force_A=0.0)
        made.restore(made.serialize())


def test_a_failed_trace_leaves_the_state_as_it_was(coulomb_model):
    """Also the internal step, which becomes short while the amplitude leaves the table."""
    component = fmu.Component(coulomb_model, FORCE_PATTERNS)
    component.set_inputs(**START)
    component.do_step(0.0, 10.0)
    state = component.get_state()
    row = [
        {**START, "limit_scale": 1.0, "force_A": 1e100}.get(n, 0.0) for n in component.input_names
    ]
    with pytest.raises(fmu.StoppedError) as stop:
        next(component.trace(np.array([5.0]), np.array([row])))
    assert len(stop.value.outputs) == 0
    np.testing.assert_array_equal(component.get_state(), state)


@pytest.mark.parametrize("call", ["run", "trace"])
def test_steps_whose_motion_cannot_be_computed_are_counted(call):
    """Two modes of 1e-4 and 1e12 rad/s: a second is too many periods of the second one."""
    frequency = np.array([1e-4, 1e12])

    def rates(amplitudes):
        return np.array([1e-6, 0.1]) + 0.0 * amplitudes, frequency + 0.0 * amplitudes

    with warnings.catch_warnings(action="ignore"):  # such frequencies are implausible
        model = rom.model_of_rates(rates, (3.0, 3.0), 3e-2, mode_shapes=np.eye(2))
    component = fmu.Component(model, FORCE_PATTERNS, contact=True, elastic=(0,), warned=False)
    inputs = np.zeros((3, len(component.input_names)))
    for name, values in {
        "force_A": (1e-9, 2e-9, 3e-9),
        "frequency_A": 1e-4,
        "frequency_B": 1e12,
    }.items():
        inputs[:, component.input_names.index(name)] = values
    steps = np.full(3, 1e5)
    with pytest.raises(fmu.StoppedError, match=r"^outputs at t = ") as stop:
        component.run(steps, inputs) if call == "run" else list(component.trace(steps, inputs))
    last = dict(zip(component.output_names, stop.value.outputs[-1], strict=True))
    assert np.isnan(last["x_0"]) and last["time"] == component.time == stop.value.time > 0.0
    # On with the inputs of the failed step, as after a step whose outputs are not read
    twin = fmu.Component(model, FORCE_PATTERNS, warned=False)
    twin.set_inputs(force_A=1e-9, frequency_A=1e-4, frequency_B=1e12)
    twin.do_step(0.0, component.time)
    for each in (component, twin):
        each.do_step(each.time, 1e5)
    component, twin = (each.get_state()[8:12] for each in (component, twin))
    np.testing.assert_allclose(component, twin, rtol=1e-6)
