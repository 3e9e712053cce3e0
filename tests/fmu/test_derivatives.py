"""Derivatives that an FMU offers: against differences, and refused where there are none."""

import ctypes
import re

import fmpy
import numpy as np
import pytest
from fmu_exchange import AMPLITUDES, STATES, Master
from fmu_fixtures import DISCARD, ERROR, instance

AT = {"A_re": 1.1, "A_im": -0.4, "B_re": 0.3, "B_im": 0.5, "force_rate_A": 1e-3}
POLAR = ("A_abs", "A_phase", "B_abs", "B_phase")


def directional(made, unknowns, known):
    unknown = [made.reference[name] for name in unknowns]
    return made.fmu.getDirectionalDerivative(unknown, [made.reference[known]], [1.0])


def unknowns_of(folder):
    """Names of outputs and derivatives in the model structure that are real, not arrays."""
    description = fmpy.read_model_description(folder)
    listed = [u.variable for u in (*description.outputs, *description.derivatives)]
    return [v.name for v in listed if v.type in ("Real", "Float64") and not v.dimensions]


@pytest.mark.oracle
def test_directional_derivatives_are_the_limit_of_differences(scalable, fmi):
    """Of every derivative and output, by every input and state; and dependencies list them."""
    unknowns, step = unknowns_of(scalable[fmi]), 1e-5
    assert {*STATES, *POLAR, "input_power", "dissipated_power", "der(A_re)"} <= {*unknowns}
    description = fmpy.read_model_description(scalable[fmi])
    inputs = [v.name for v in description.modelVariables if v.causality == "input"]
    assert "limit_scale" in inputs
    with instance(scalable[fmi], fmi, exchange=True) as made:
        master = Master(made).start(**AT)
        base = master.states() + np.array([name.startswith("theta") for name in STATES])
        master.put(0.0, base)  # angles away from 0, where what is read jumps by a turn

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

        found = {}
        for name in (*STATES, *inputs):
            expected = (values(name, step) - values(name, -step)) / (2.0 * step)
            found[name] = dict(zip(unknowns, directional(made, unknowns, name), strict=True))
            np.testing.assert_allclose(
                list(found[name].values()), expected, atol=2e-4, err_msg=name
            )
    for unknown in description.derivatives:
        listed = {v.name for v in unknown.dependencies}
        for name in (*STATES, *inputs):
            assert name in listed or found[name][unknown.variable.name] == 0.0


@pytest.mark.oracle
def test_directional_derivatives_of_contact_motion_are_the_limit_of_differences(unzipped, fmi):
    """To 10 %: the motion is marched where it is read, in other steps."""
    names = [f"contact_{i}_{letter}" for letter in "xf" for i in range(2)] + ["x_0", "x_1"]
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        master = Master(made).start(**AT)
        base = master.states()
        for name in ("A_re", "B_im", "theta_A"):
            ends = []
            for change in (0.02, -0.02):
                master.put(0.0, base + change * (np.array(STATES) == name))
                ends.append(made.get(*names))
            master.put(0.0, base)
            expected = (ends[0] - ends[1]) / 0.04
            found = np.array(directional(made, names, name))
            for those in (slice(0, 2), slice(2, 4), slice(4, 6)):  # of one unit
                largest = np.abs(expected[those]).max()
                assert np.abs(found - expected)[those].max() < 0.1 * largest, (name, names[those])


@pytest.mark.oracle
def test_adjoint_derivatives_are_the_transposed_ones(unzipped):
    """Of all outputs by states and inputs together; of arrays as of their elements."""
    names, known = unknowns_of(unzipped[3]), ["A_re", "B_im", "theta_B", "force_A", "frequency_B"]
    with instance(unzipped[3], 3) as made:
        made.start(**AT).step(0.0, 3.0)
        columns = np.array([directional(made, names, name) for name in known])
        seed = np.random.default_rng(3).normal(size=len(names))
        unknown, by = ([made.reference[n] for n in those] for those in (names, known))
        found = made.fmu.getAdjointDerivative(unknown, by, seed, len(known))
        np.testing.assert_allclose(found, columns @ seed, rtol=1e-12)


@pytest.mark.oracle
def test_where_contact_motion_is_not_wanted_its_derivatives_are_zero(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.fmu.setBoolean([made.reference["contact_wanted"]], [False])
        made.start(**AT)
        assert directional(made, ["contact_0_x", "x_1"], "A_re") == [0.0, 0.0]


def time_derivatives(made, names):
    """dv/dt of outputs."""
    count, values = len(names), (ctypes.c_double * len(names))()
    references = (ctypes.c_uint32 * count)(*(made.reference[name] for name in names))
    order = (ctypes.c_int32 * count)(*[1] * count)
    call = {2: "fmi2GetRealOutputDerivatives", 3: "fmi3GetOutputDerivatives"}[made.fmi]
    counts = [count] if made.fmi == 3 else []
    getattr(made.fmu, call)(made.fmu.component, references, count, order, values, *counts)
    return np.array(values)


@pytest.mark.oracle
def test_derivatives_of_outputs_by_time_are_the_limit_of_differences(scalable, fmi):
    """While inputs move."""
    names = [*AMPLITUDES, *POLAR, "input_power", "dissipated_power", "dissipated_energy"]
    with instance(scalable[fmi], fmi) as made:
        made.start(**AT, frequency_rate_B=1e-3, limit_scale_rate=1e-3, tolerance=1e-9)
        made.step(0.0, 5.0)
        h, values = 1e-3, []
        for k in range(3):
            values.append(made.get(*names))
            if k == 1:
                found = time_derivatives(made, names)
            made.step(5.0 + k * h, h)
        expected = (values[2] - values[0]) / (2 * h)
        np.testing.assert_allclose(found, expected, rtol=2e-4, atol=2e-6)


@pytest.mark.oracle
def test_from_rest_a_modulus_grows_at_the_rate_of_the_amplitude(scalable, fmi):
    with instance(scalable[fmi], fmi) as made:
        made.start()
        modulus, phase = time_derivatives(made, ["A_abs", "A_phase"])
        rate = made.get("der(A_re)", "der(A_im)")
        assert phase == 0.0 and modulus == pytest.approx(np.hypot(*rate)) and modulus > 0.0


def test_at_rest_moduli_and_phases_have_no_derivatives(scalable, fmi):
    """The call is discarded, the instance goes on."""
    with instance(scalable[fmi], fmi) as made:
        made.start(B_re=0.1)
        for name in ("A_abs", "A_phase"):
            status, message = made.refused(directional, made, [name], "A_re")
            assert status == DISCARD
            assert name in message and "where the amplitude is zero" in message
        assert directional(made, ["B_abs"], "B_re") == [1.0]
        made.step(0.0, 1.0)
        assert np.isfinite(directional(made, ["A_abs", "A_phase"], "A_re")).all()


NONE = [
    (lambda m: directional(m, ["damping_A"], "A_re"), "damping_A, .* has no deriv"),
    (lambda m: directional(m, ["der(A_re)"], "damping_A"), "damping_A, .* is neither a state"),
    (lambda m: time_derivatives(m, ["force_A"]), "force_A, .* is no output"),
]


@pytest.mark.parametrize(("call", "reason"), NONE)
def test_derivatives_that_do_not_exist_are_refused_by_name(scalable, fmi, call, reason):
    with instance(scalable[fmi], fmi) as made:
        made.start(**AT)
        status, message = made.refused(call, made)
        assert status == ERROR
        assert re.search(reason, message)
