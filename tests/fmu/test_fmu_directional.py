"""Directional derivatives: right where there are some, refused by name where there are none."""

import fmpy
import numpy as np
import pytest
from fmu_exchange import STATES, Master
from fmu_fixtures import VERSIONS, instance
from lxml import etree

FMI_ERRORS = fmpy.fmi1.FMICallException
DISCARD, ERROR = 2, 3
AT = {"A_re": 1.1, "A_im": -0.4, "B_re": 0.3, "B_im": 0.5, "force_rate_A": 1e-3}
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
    """Names of outputs and derivatives in the model structure that are real."""
    description = fmpy.read_model_description(folder)
    listed = [u.variable for u in (*description.outputs, *description.derivatives)]
    return [v.name for v in listed if v.type in ("Real", "Float64")]


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
def test_they_are_announced_where_everything_has_some(scalable, unzipped, fmi, exchange):
    """Contact motion has none: whoever claims them claims those of all outputs."""
    for folder, all_have in ((scalable[fmi], True), (unzipped[fmi], False)):
        assert announced(folder) == all_have
        without = []
        with instance(folder, fmi, exchange=exchange) as made:
            made.start(**AT)
            for name in unknowns_of(folder):
                try:
                    directional(made, [name], "force_A")
                except FMI_ERRORS:
                    without.append(name)
                    status, message = made.messages[-1]
                    assert status == ERROR
                    assert f": {name}, value reference {made.reference[name]}, has no" in message
                    assert "contacts are marched over the last periods" in message
        marched = [f"contact_{i}_{letter}" for letter in "xvf" for i in range(2)]
        assert without == ([] if all_have else [*marched, "x_0", "x_1"])


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
