"""FMUs of models of given rates, which have no contacts: steps, state, displacements, the page."""

import shutil
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_fixtures import VERSIONS, instance
from scipy.integrate import solve_ivp

from slipmode import fmu, rom

RANGE = 2e-3
REST = 2.0 * np.pi * np.array([122.0, 243.0])
SHAPES = [[1.2, 0.7], [0.4, -1.1], [0.9, 0.2]]
LARGEST = 0.01  # kg^1/2 m, where the table of `damped` ends
PATTERNS = ({0: 1.0}, {1: 1.0})
STATES = ("A_re", "A_im", "B_re", "B_im")
ALL = (*STATES, "theta_A", "theta_B", "dissipated_energy", "x_0", "x_1", "x_2")


def rates(amplitudes):
    a, b = amplitudes.T
    s = np.sqrt(np.stack((a**2 + 0.2 * b**2, b**2 + 0.8 * a**2), axis=-1)) / RANGE
    return np.array([1.5, 2.2]) + [2.0, 3.0] * s, REST - [6.0, 9.0] * s


@pytest.fixture(scope="module")
def model():
    return rom.model_of_rates(rates, (RANGE, RANGE), mode_shapes=SHAPES)


@pytest.fixture(scope="module")
def exported(model, tmp_path_factory):
    """{fmi: (file, folder)}"""
    folder, made = tmp_path_factory.mktemp("identified"), {}
    for fmi in VERSIONS:
        options = {"contact": True, "elastic": (0, 1, 2)}
        path = fmu.export(model, folder / f"{fmi}.fmu", PATTERNS, fmi=fmi, **options)
        shutil.unpack_archive(path, folder / str(fmi), format="zip")
        made[fmi] = path, folder / str(fmi)
    return made


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def component(model):
    return fmu.Component(model, PATTERNS, contact=True, elastic=(0, 1, 2))


def test_an_fmu_has_the_components_bits(exported, fmi, model):
    inputs = {"force_A": 0.4, "force_B": 0.7, "frequency_A": 0.999 * REST[0]}
    stepped = component(model)
    stepped.set_inputs(**inputs)
    with instance(exported[fmi][1], fmi) as made:
        made.start(**inputs)
        time = 0.0
        for duration in (0.01, 0.3, 1e-3, 0.2):
            stepped.do_step(time, duration)
            made.step(time, duration)
            time = stepped.time
            expected = stepped.outputs()
            assert list(made.get(*ALL)) == [expected[name] for name in ALL]
        kept = made.serialize()
        made.step(time, 0.1)
        after = made.get(*ALL)
        made.restore(kept)
        made.step(time, 0.1)
        np.testing.assert_array_equal(made.get(*ALL), after)


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_a_ring_down_is_that_of_the_law(exported, fmi, kind):
    start = {"A_re": 0.7 * RANGE, "B_re": 0.5 * RANGE, "B_im": -0.6 * RANGE}
    result = fmpy.simulate_fmu(
        exported[fmi][0],
        stop_time=1.0,
        output_interval=0.01,
        fmi_type=kind,
        start_values=start,
        relative_tolerance=1e-8,
        output=STATES,
    )

    carriers = np.hypot([1.5, 2.2], REST)  # the inputs start at the undamped frequencies

    def growth(_, y):
        a = y.view(complex)
        (damping,), (frequency,) = rates(np.abs(a)[np.newaxis])
        return ((-damping + 1j * (frequency - carriers)) * a).view(float)

    y = np.array([start.get(name, 0.0) for name in STATES])
    times = result["time"]
    exact = solve_ivp(growth, (0.0, 1.0), y, t_eval=times, rtol=1e-10, atol=1e-14).y.T
    found = np.stack([result[name] for name in STATES], axis=-1)
    np.testing.assert_allclose(found, exact, atol=3e-5 * RANGE)  # measured 8.2e-6


def test_displacements_are_the_modes_and_the_forced_response(model):
    stepped = component(model)
    stepped.set_inputs(force_A=0.4)
    stepped.do_step(0.0, 0.37)
    found = stepped.outputs()
    a = np.array([found["A_re"] + 1j * found["A_im"], found["B_re"] + 1j * found["B_im"]])
    q = 2.0 * (a * np.exp(1j * np.array([found["theta_A"], found["theta_B"]]))).real
    Omega = model.reduced.frequency[0]
    receptance = 1.0 / (model.reduced.frequency[1] ** 2 - Omega**2 + 1j * Omega * 4.4)
    q[1] += (0.4 * SHAPES[0][1] * receptance * np.exp(1j * found["theta_A"])).real
    x = [found[f"x_{dof}"] for dof in range(3)]
    np.testing.assert_allclose(x, np.array(SHAPES) @ q, rtol=1e-9, atol=1e-12 * RANGE)


def test_the_description_is_valid_and_names_no_contacts(exported, fmi):
    path, _ = exported[fmi]
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(path, validate=True)
    names = [variable.name for variable in description.modelVariables]
    assert not any(name.startswith(("contact_0", "contact_x", "limit_scale")) for name in names)
    with zipfile.ZipFile(path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "<td>Contacts</td><td>0</td>" in page
    assert "<td>Contact law</td><td>none</td>" in page


def test_the_state_of_a_component_continues_the_run(model):
    one, other = component(model), component(model)
    one.set_inputs(force_A=0.4, force_B=0.2)
    one.do_step(0.0, 0.2)
    other.set_state(one.get_state())
    one.do_step(0.2, 0.1)
    other.do_step(0.2, 0.1)
    assert one.outputs() == other.outputs()
    np.testing.assert_array_equal(one.transient_error(), 0.0)


def damped(damping):
    return rom.model_of_rates(
        lambda r: (np.full_like(r, damping), np.full_like(r, 100.0)), amplitude=[LARGEST]
    )


def driven_to_the_edge(component, force):
    """With steps that are halved where they are refused, as importers do it."""
    component.set_inputs(force_A=force)
    step = 0.5
    while step > 1e-6:
        try:
            component.do_step(component.time, step)
        except rom.SlipmodeError:
            step /= 2.0
    return np.hypot(component.outputs()["A_re"], component.outputs()["A_im"])


@pytest.mark.parametrize("seed", range(4))
def test_a_smaller_force_is_a_way_back(seed):
    """Also no force; then the amplitude decays at the damping rate."""
    rng = np.random.default_rng(seed)
    damping, phase = 10.0 ** rng.uniform(-0.5, 1.0), rng.uniform(0.0, 2.0 * np.pi)
    component = fmu.Component(damped(damping))
    component.set_inputs(phase_A=phase)
    # The steady amplitude |a| is F / (4 omega delta): three times the edge.
    size = driven_to_the_edge(component, 3.0 * LARGEST * 4.0 * 100.0 * damping)
    assert 0.99 * LARGEST < size <= LARGEST
    component.set_inputs(force_A=0.0)
    component.do_step(component.time, 0.5)
    left = np.hypot(component.outputs()["A_re"], component.outputs()["A_im"])
    # The change of force itself moves the amplitude by at most the damping ratio, times 3.
    assert left == pytest.approx(size * np.exp(-0.5 * damping), rel=6.0 * damping / 100.0)
