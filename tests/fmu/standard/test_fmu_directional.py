"""Directional derivatives: right where there are some, refused by name where there are none."""

import ctypes

import fmpy
import numpy as np
import pytest
from fmu_exchange import STATES, Master
from fmu_fixtures import VERSIONS, instance
from lxml import etree

FMI_ERRORS = fmpy.fmi1.FMICallException
DISCARD, ERROR = 2, 3
AT = {"A_re": 1.1, "A_im": -0.4, "B_re": 0.3, "B_im": 0.5, "force_rate_A": 1e-3}
AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")
POLAR = ("A_abs", "A_phase", "B_abs", "B_phase")


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def directional(made, unknowns, known):
    unknown = [made.reference[name] for name in unknowns]
    return made.fmu.getDirectionalDerivative(unknown, [made.reference[known]], [1.0])


def refusal(made, unknown, known="A_re"):
    """Status and message of a call that is refused."""
    with pytest.raises(FMI_ERRORS):
        directional(made, [unknown], known)
    return made.messages[-1]


def announced(folder):
    """What both interfaces say of directional derivatives."""
    root = etree.parse(folder / "modelDescription.xml").getroot()
    said = {
        value
        for interface in (*root.iter("ModelExchange"), *root.iter("CoSimulation"))
        for name, value in interface.attrib.items()
        if name.startswith("providesDirectionalDerivative")
    }
    (one,) = said
    return one == "true"


def unknowns_of(folder):
    """Names of outputs and derivatives in the model structure that are real, not arrays."""
    description = fmpy.read_model_description(folder)
    listed = [u.variable for u in (*description.outputs, *description.derivatives)]
    return [v.name for v in listed if v.type in ("Real", "Float64") and not v.dimensions]


def test_they_are_those_of_differences(scalable, fmi):
    """Of every derivative and output, by every input and state."""
    unknowns = unknowns_of(scalable[fmi])
    assert {*STATES, *POLAR, "input_power", "dissipated_power", "der(A_re)"} <= {*unknowns}
    step = 1e-5
    with instance(scalable[fmi], fmi, exchange=True) as made:
        master = Master(made).start(**AT)
        base = master.states() + np.array([name.startswith("theta") for name in STATES])
        master.put(0.0, base)  # angles away from 0, where what is read jumps by a turn
        description = fmpy.read_model_description(scalable[fmi])
        inputs = [v.name for v in description.modelVariables if v.causality == "input"]
        assert "limit_scale" in inputs

        def values(name, change):
            if name in STATES:
                master.put(0.0, base + change * (np.array(STATES) == name))
                result = made.get(*unknowns)
                master.put(0.0, base)
                return result
            before = made.get(name)[0]
            made.set(**{name: before + change})
            result = made.get(*unknowns)
            made.set(**{name: before})
            return result

        for name in (*STATES, *inputs):
            expected = (values(name, step) - values(name, -step)) / (2 * step)
            analytic = directional(made, unknowns, name)
            np.testing.assert_allclose(analytic, expected, atol=2e-4, err_msg=name)


@pytest.mark.parametrize("exchange", [False, True])
def test_they_are_announced_and_everything_has_some(scalable, unzipped, fmi, exchange):
    for folder in (scalable[fmi], unzipped[fmi]):
        assert announced(folder)
        with instance(folder, fmi, exchange=exchange) as made:
            made.start(**AT)
            found = directional(made, unknowns_of(folder), "A_re")
            assert np.isfinite(found).all() and np.count_nonzero(found) > 5


def test_those_of_contact_motion_are_of_differences(unzipped, fmi):
    """As the motion is marched where it is read, but for the steps that are halved there."""
    names = [f"contact_{i}_{letter}" for letter in "xf" for i in range(2)] + ["x_0", "x_1"]
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        master = Master(made).start(**AT)
        base = master.states()
        for name in ("A_re", "B_im", "theta_A"):
            change = 0.02 * (np.array(STATES) == name)
            ends = []
            for sign in (1.0, -1.0):
                master.put(0.0, base + sign * change)
                ends.append(made.get(*names))
            master.put(0.0, base)
            expected = (ends[0] - ends[1]) / 0.04
            found = np.array(directional(made, names, name))
            for those in (slice(0, 2), slice(2, 4), slice(4, 6)):  # of one unit
                largest = np.abs(expected[those]).max()
                assert np.abs(found - expected)[those].max() < 0.1 * largest, (name, names[those])


def test_where_contact_motion_is_not_wanted_it_does_not_change(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        put = made.fmu.setBoolean
        put([made.reference["contact_wanted"]], [False])
        made.start(**AT)
        assert directional(made, ["contact_0_x", "x_1"], "A_re") == [0.0, 0.0]


def test_adjoint_derivatives_are_the_transposed_ones(unzipped):
    """Of all outputs by states and inputs together."""
    names, known = unknowns_of(unzipped[3]), ["A_re", "B_im", "theta_B", "force_A", "frequency_B"]
    random = np.random.default_rng(3)
    with instance(unzipped[3], 3) as made:
        made.start(**AT)
        made.step(0.0, 3.0)
        columns = np.array([directional(made, names, name) for name in known])
        seed = random.normal(size=len(names))
        unknown = [made.reference[name] for name in names]
        found = made.fmu.getAdjointDerivative(
            unknown, [made.reference[n] for n in known], seed, len(known)
        )
    np.testing.assert_allclose(found, columns @ seed, rtol=1e-12)


def output_derivatives(made, names):
    """dv/dt of outputs."""
    values = (ctypes.c_double * len(names))()
    references = (ctypes.c_uint32 * len(names))(*(made.reference[name] for name in names))
    order = (ctypes.c_int32 * len(names))(*[1] * len(names))
    call = {2: "fmi2GetRealOutputDerivatives", 3: "fmi3GetOutputDerivatives"}[made.fmi]
    counts = [len(names)] if made.fmi == 3 else []
    function = getattr(made.fmu, call)
    status = function(made.fmu.component, references, len(names), order, values, *counts)
    return status, np.array(values)


def test_outputs_have_derivatives_by_time(scalable, fmi):
    """As differences over short steps say, while inputs move."""
    names = [*AMPLITUDES, *POLAR, "input_power", "dissipated_power", "dissipated_energy"]
    with instance(scalable[fmi], fmi) as made:
        made.start(**AT, frequency_rate_B=1e-3, limit_scale_rate=1e-3, tolerance=1e-9)
        made.step(0.0, 5.0)
        h, values = 1e-3, []
        for k in range(3):
            values.append(made.get(*names))
            if k == 1:
                _, found = output_derivatives(made, names)
            made.step(5.0 + k * h, h)
        expected = (values[2] - values[0]) / (2 * h)
        np.testing.assert_allclose(found, expected, rtol=2e-4, atol=2e-6)


def test_the_derivative_of_a_displacement_is_the_velocity(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start(**AT)
        made.step(0.0, 40.0)
        _, found = output_derivatives(made, ["contact_0_x", "contact_1_x"])
        velocity = made.get("contact_0_v", "contact_1_v")
    assert np.abs(found - velocity).max() < 0.1 * np.abs(velocity).max()


def test_from_rest_a_modulus_grows(scalable, fmi):
    with instance(scalable[fmi], fmi) as made:
        made.start()
        status, (modulus, phase) = output_derivatives(made, ["A_abs", "A_phase"])
        rate = made.get("der(A_re)", "der(A_im)")
        assert status == 0 and phase == 0.0
        assert modulus == pytest.approx(np.hypot(*rate)) and modulus > 0.0


@pytest.mark.parametrize("name", ["force_A", "time", "damping_A", "der(A_re)"])
def test_what_is_no_output_has_no_derivative_by_time(scalable, fmi, name):
    with instance(scalable[fmi], fmi) as made:
        made.start(**AT)
        with pytest.raises(FMI_ERRORS):
            output_derivatives(made, [name])
        assert (
            f"{name}, value reference {made.reference[name]}, is no output" in made.messages[-1][1]
        )


def test_at_rest_moduli_and_phases_have_none(scalable, fmi):
    """Elsewhere they have: the call is discarded, the instance goes on."""
    with instance(scalable[fmi], fmi) as made:
        made.start(B_re=0.1)
        for name in ("A_abs", "A_phase"):
            status, message = refusal(made, name)
            assert status == DISCARD
            assert f"{name}, value reference" in message
            assert "where the amplitude is zero" in message
        assert directional(made, ["B_abs"], "B_re") == [1.0]
        made.step(0.0, 1.0)
        assert np.isfinite(directional(made, ["A_abs", "A_phase"], "A_re")).all()


@pytest.mark.parametrize("unknown", ["force_A", "damping_A", "time"])
def test_what_is_calculated_by_nobody_has_none(scalable, fmi, unknown):
    with instance(scalable[fmi], fmi) as made:
        made.start(**AT)
        status, message = refusal(made, unknown)
        assert status == ERROR
        assert f"{unknown}, value reference {made.reference[unknown]}, has no deriv" in message


@pytest.mark.parametrize("known", ["damping_A", "time", "A_abs", "input_power"])
def test_they_are_by_states_and_inputs_alone(scalable, fmi, known):
    with instance(scalable[fmi], fmi) as made:
        made.start(**AT)
        status, message = refusal(made, "der(A_re)", known)
        assert status == ERROR
        assert f"{known}, value reference {made.reference[known]}, is neither a state" in message
