"""Co-Simulation in FMPy: the component's bits, state, refusals, the table's end."""

import ctypes
import re
import shutil
import struct
import zlib
from urllib.parse import quote

import fmpy
import numpy as np
import pytest
from elastic import cantilever
from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated
from fmu_exchange import AMPLITUDES
from fmu_fixtures import (
    DISCARD,
    ERROR,
    FMI_ERRORS,
    FORCE_PATTERNS,
    START,
    VERSIONS,
    Instance,
    instance,
    not_made,
    unpacked,
)

from slipmode import fmu, rom

SLOW = (*AMPLITUDES, "theta_A", "theta_B", "dissipated_energy")
FAST = ("contact_0_x", "contact_1_v", "contact_0_f", "x_0", "x_1")

# A model of given rates, without contacts

RANGE = 2e-3
REST = 2.0 * np.pi * np.array([122.0, 243.0])


def rates(amplitudes):
    """Decay and frequency of both modes."""
    a, b = amplitudes.T
    s = np.sqrt(np.stack((a**2 + 0.2 * b**2, b**2 + 0.8 * a**2), axis=-1)) / RANGE
    return np.array([1.5, 2.2]) + [2.0, 3.0] * s, REST - [6.0, 9.0] * s


@pytest.fixture(scope="module")
def models(two_mode_model):
    """{name: (model, force patterns, options, inputs)}"""
    shapes = [[1.2, 0.7], [0.4, -1.1], [0.9, 0.2]]
    of_rates = rom.model_of_rates(rates, (RANGE, RANGE), mode_shapes=shapes)
    beam = cantilever.model("mixed")
    stiffness, law = np.diag([1.0, 1.06, 1.17, 12.0]), rom.Jenkins((0.02, 0.03), (0.05, 0.08))
    contact = [[0.9, 0.2], [0.4, 0.8], [0.3, 0.5], [1.0, 1.0]]
    structure = rom.Structure(np.eye(4), stiffness, 0.01 * np.eye(4), contact=contact)
    tone = rom.tabulate(rom.reduce(structure, range(4), law=law, tones=(0, 0, 0, 1)), law)
    forced = {"force_A": 1.0, "frequency_A": 1.02, "force_B": 0.5, "frequency_B": 3.5}
    return {
        "tone": (tone, [{0: 0.06, 1: 0.03j, 2: 0.04}, {3: 0.05}], (0, 3), forced),
        "friction": (two_mode_model, FORCE_PATTERNS, (0, 1), START),
        "elastic": (beam, cantilever.FORCE_PATTERNS, cantilever.DOFS, cantilever.FORCES),
        "rates": (of_rates, FORCE_PATTERNS, (0, 1, 2), {"force_A": 0.4, "force_B": 0.7}),
    }


@pytest.fixture(scope="module")
def exported(models, fmus, tmp_path_factory):
    """{(name, fmi): folder}"""
    top, made = tmp_path_factory.mktemp("models"), {}
    for name, (model, patterns, dofs, inputs) in models.items():
        for fmi in VERSIONS:
            path = top / f"{name} {fmi}.fmu"
            options = {"contact": True, "elastic": dofs, "start": inputs, "fmi": fmi}
            fmu.export(model, path, patterns, **options)
            made[name, fmi] = unpacked(path, path.with_suffix(""))
    return made


def present(names, **values):
    """The values of these names."""
    return {name: value for name, value in values.items() if name in names}


@pytest.mark.parametrize("name", ["friction", "elastic", "rates", "tone"])
def test_co_simulation_has_the_bits_of_the_component(exported, models, fmi, name):
    """Steps of any length, inputs that move, and one input set while others go on moving."""
    model, patterns, dofs, inputs = models[name]
    unit = 1.0 if name in ("friction", "tone") else 0.05
    stepped = fmu.Component(model, patterns, contact=True, elastic=dofs)
    known = stepped.input_names
    moving = present(known, frequency_rate_A=1.3e-4, force_rate_B=-7e-4, phase_rate_A=3e-3)
    stepped.set_inputs(**inputs, **moving)
    names = stepped.output_names
    with instance(exported[name, fmi], fmi) as made:
        made.start(**moving)
        for k, duration in enumerate((3.7, 0.1, 11.3, 1 / 3, 20.0)):
            jump = present(known, phase_B=0.1 * k, force_A=(1.0 + 0.1 * k) * inputs["force_A"])
            stepped.set_inputs(**jump)
            made.set(**jump)
            made.step(stepped.time, unit * duration)
            stepped.do_step(stepped.time, unit * duration)
            assert dict(zip(names, made.get(*names), strict=True)) == stepped.outputs()


def test_a_sample_has_the_bits_of_the_component(tmp_path, fmi):
    def other(amplitudes):
        damping, frequency = rates(amplitudes)
        return 1.2 * damping, frequency - 0.3

    model = rom.model_of_rates(rates, (RANGE, RANGE), samples=[rates, other])
    options = {"contact": True, "elastic": (0, 1)}
    fmu.export(
        model, tmp_path / "x.fmu", FORCE_PATTERNS, start={"force_A": 0.4}, fmi=fmi, **options
    )
    stepped = fmu.Component(model, FORCE_PATTERNS, sample=2, **options)
    stepped.set_inputs(force_A=0.4)
    names = stepped.output_names
    with instance(unpacked(tmp_path / "x.fmu", tmp_path / "x"), fmi) as made:
        made.start(sample=2.0)
        for duration in (0.37, 0.01, 1.13):
            made.step(stepped.time, duration)
            stepped.do_step(stepped.time, duration)
            assert dict(zip(names, made.get(*names), strict=True)) == stepped.outputs()
        for refused in (3.0, 0.5):
            with pytest.raises(FMI_ERRORS):
                made.set(sample=refused)
        assert made.get("sample") == [2.0]


@pytest.mark.oracle
def test_displacements_are_the_modes_and_the_forced_response(exported, models, fmi):
    """x = sum_j phi_j q_j; B also responds to the force on A, by its receptance."""
    dofs = models["rates"][2]
    shapes = np.array([[1.2, 0.7], [0.4, -1.1], [0.9, 0.2]])
    with instance(exported["rates", fmi], fmi) as made:
        made.start(force_A=0.4, force_B=0.0).step(0.0, 0.37)
        a = made.get("A_re", "B_re") + 1j * made.get("A_im", "B_im")
        theta = made.get("theta_A", "theta_B")
        x = made.get(*(f"x_{dof}" for dof in dofs))
    q = 2.0 * (a * np.exp(1j * theta)).real
    Omega, w = np.hypot([1.5, 2.2], REST)
    receptance = 1.0 / (w**2 - Omega**2 + 1j * Omega * 4.4)
    q[1] += (0.4 * shapes[0, 1] * receptance * np.exp(1j * theta[0])).real
    np.testing.assert_allclose(x, shapes @ q, rtol=1e-9, atol=1e-12 * RANGE)


@pytest.mark.oracle
def test_a_mode_decays_or_grows_by_its_damping(unzipped, fmi):
    """A self-excited mode, as flutter makes it, grows. Friction adds the same to all three."""
    found = []
    for damping in (0.01, 0.1, -0.02):
        with instance(unzipped[fmi], fmi) as made:
            made.start(A_re=0.5, force_A=0.0, damping_A=damping).step(0.0, 20.0)
            found.append(made.get("A_abs")[0])
    assert found[1] / found[0] == pytest.approx(np.exp(-0.5 * 0.09 * 20.0), rel=0.02)
    assert found[2] / found[0] == pytest.approx(np.exp(0.5 * 0.03 * 20.0), rel=0.02)


def test_fmi2_input_derivatives_are_rates(unzipped):
    with instance(unzipped[2], 2) as one, instance(unzipped[2], 2) as other:
        one.start(force_rate_A=1e-3).step(0.0, 10.0)
        other.start()
        other.fmu.setRealInputDerivatives([other.reference["force_A"]], [1], [1e-3])
        other.step(0.0, 10.0)
        np.testing.assert_array_equal(one.get(*SLOW), other.get(*SLOW))


def test_start_values_take_effect_and_reset_starts_anew(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made, instance(unzipped[fmi], fmi) as fresh:
        made.start(time=5.0, A_re=0.3, A_im=-0.4, damping_A=0.02)
        found = made.get("time", "A_re", "A_im", "A_abs", "A_phase")
        np.testing.assert_allclose(found, [5.0, 0.3, -0.4, 0.5, np.arctan2(-0.4, 0.3)], rtol=1e-15)
        made.step(5.0, 20.0)
        made.fmu.reset()
        for each in (made, fresh):
            each.start().step(0.0, 20.0)
        np.testing.assert_array_equal(made.get(*SLOW), fresh.get(*SLOW))


# Saved states


@pytest.mark.parametrize("name", ["friction", "elastic", "tone"])
def test_a_saved_state_continues_to_the_same_bits(exported, models, fmi, name):
    model, patterns, dofs, _ = models[name]
    component = fmu.Component(model, patterns, contact=True, elastic=dofs)
    names, known, time = component.output_names, component.input_names, 0.0
    unit = 0.05 if name == "elastic" else 1.0
    with instance(exported[name, fmi], fmi) as made, instance(exported[name, fmi], fmi) as twin:
        made.start(**present(known, frequency_rate_A=1.3e-4, force_rate_B=-7e-4))
        for k, duration in enumerate((3.7, 0.1, 11.3, 1 / 3, 20.0)):
            made.set(**present(known, phase_B=0.1 * k, phase_rate_A=0.01 * k))
            made.step(time, unit * duration)
            time += unit * duration
        kept = made.serialize()
        twin.start(force_A=1e-3).step(0.0, 0.05)  # a past to be forgotten
        twin.restore(kept)
        assert twin.serialize() == kept and made.get("dissipated_energy")[0] > 0.0
        for each in (made, twin):
            each.step(time, 14.0 * unit)
        np.testing.assert_array_equal(made.get(*names), twin.get(*names))


def test_states_of_other_models_and_parts_of_states_are_refused(unzipped, scalable, fmi):
    with instance(unzipped[fmi], fmi) as made, instance(scalable[fmi], fmi) as other:
        saved = made.start().serialize()
        assert "another model" in other.refused(other.restore, saved + bytes(1000))[1]
        assert "too few" in made.refused(made.restore, saved[:-1])[1]
        assert made.serialize() == saved


# Refusals: the instance is as before

MEET = "frequency_A, frequency_B: must differ at all times"
WRONG_CALLS = [
    (lambda m: m.step(0.0, 0.0), "step 0 s: must be finite and > 0"),
    (lambda m: m.step(0.0, np.nan), "step nan s"),
    (lambda m: m.step(3.0, 1.0), "t = 3 s: must be the present time of the FMU, 0 s"),
    (lambda m: m.step(0.0, 200.0), "past the stop time"),
    (lambda m: m.set(force_A=np.nan), "force_A: must be finite, got nan"),
    (lambda m: m.set(frequency_B=-1.0), "frequency_B: must be > 0"),
    (lambda m: m.set(A_abs=1.0), "A_abs: is not an input or parameter"),
    (lambda m: m.set(A_re=0.1), "A_re: not allowed while the instance is in step mode"),
    (lambda m: m.set(tolerance=0.1), "tolerance: must be 1e-13 to 0.01, got 0.1"),
    (lambda m: m.fmu.exitInitializationMode(), "ExitInitializationMode: not allowed"),
    (lambda m: m.get("contact_wanted"), "contact_wanted: is a boolean"),
    (lambda m: m.restore(bytes(64)), "the bytes are too few"),
]


def test_wrong_calls_are_refused_and_named_and_change_nothing(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made, instance(unzipped[fmi], fmi) as twin:
        for each in (made, twin):
            each.start(stop=100.0)
        for call, reason in WRONG_CALLS:
            status, message = made.refused(call, made)
            assert status == ERROR and reason in message
            assert made.serialize() == twin.serialize()
        made.step(0.0, 1.0)
        made.fmu.terminate()
        assert "while the instance is terminated" in made.refused(made.step, 1.0, 1.0)[1]


@pytest.mark.parametrize(
    ("inputs", "later", "complaint"),
    [
        ({"frequency_B": 1.0}, False, "frequency_B: must be 1.054 to 17 rad/s, got 1"),
        ({"frequency_A": 1.5, "frequency_B": 1.5}, False, MEET),
        ({"frequency_rate_A": -0.01}, True, "frequency_A: must be 0.62 to 10 rad/s, got 0.58"),
        ({"frequency_A": 1.25, "frequency_rate_A": 0.0125, "frequency_B": 1.5}, True, MEET),
    ],
)
def test_frequencies_that_no_slow_flow_follows_are_refused(
    unzipped, fmi, inputs, later, complaint
):
    """At once, also by Model Exchange, or where they move to."""
    with instance(unzipped[fmi], fmi) as made:
        made.start()
        made.set(**inputs)
        status, message = made.refused(made.step, 0.0, 40.0)
        assert status == ERROR and complaint in message
    if not later:
        with instance(unzipped[fmi], fmi, exchange=True) as made:
            made.start().fmu.enterContinuousTimeMode()
            made.set(**inputs)
            status, message = made.refused(made.get, "der(A_re)")
            assert status == ERROR and complaint in message


def test_fmi2_resource_locations_are_uris(unzipped):
    encoded = quote((unzipped[2] / "resources").as_posix())
    plain = (unzipped[2] / "resources").as_posix()  # some importers give the path itself
    assert "%20" in encoded and "%C3%BC" in encoded and "%25" in encoded
    cases = {f"file://localhost{encoded}": None, f"FILE://{encoded}/": None, plain: None}
    cases |= {f"file:{encoded}": None, f"http://{encoded}": "is not a file: URI"}
    cases |= {f"file://elsewhere{encoded}": "on another host", "": "no resource path was given"}
    cases |= {f"file://{encoded}%2": "two hexadecimal digits", "file:///no/such": "is missing"}
    made = Instance(unzipped[2], 2)
    for location, reason in cases.items():
        made.messages.clear()
        arguments = made.fmu.guid.encode(), location.encode(), ctypes.byref(made.fmu.callbacks)
        raw = made.fmu.fmi2Instantiate(b"raw", 1, *arguments, False, False)
        assert bool(raw) == (reason is None), location
        assert reason is None or reason in made.messages[-1][1]
        if raw:
            made.fmu.fmi2FreeInstance(raw)
    made.free()


def test_what_modes_on_one_tone_do_not_have_is_refused(exported, fmi):
    folder = exported["tone", fmi]
    assert fmpy.read_model_description(folder).modelExchange is None
    (message,) = not_made(folder, fmi, exchange=True)
    assert message == "Model Exchange: not available for modes that share a tone"
    with instance(folder, fmi) as made:
        assert made.refused(made.start, frequency_A=1.3)[1].startswith("frequency_A: must be 0.95")
    with instance(folder, fmi) as made:
        before = made.start().serialize()
        known = [made.reference["A_re"]], [made.reference["force_A"]]
        _, message = made.refused(made.fmu.getDirectionalDerivative, *known, [1.0])
        assert message == "derivative: not available for modes that share a tone"
        assert made.serialize() == before


def test_numbers_that_are_not_finite_are_refused_although_their_checksum_fits(
    exported, fmi, tmp_path
):
    resources = shutil.copytree(exported["tone", fmi], tmp_path / "damaged") / "resources"
    content, sums = ((resources / f"{name}.npy").read_bytes() for name in ("tone", "checksums"))
    damaged = content[:-8] + struct.pack("<d", np.nan)
    before, after = (struct.pack("<I", zlib.crc32(each)) for each in (content, damaged))
    (resources / "tone.npy").write_bytes(damaged)
    assert "resources/tone.npy: damaged" in not_made(tmp_path / "damaged", fmi)[0]
    (resources / "checksums.npy").write_bytes(sums.replace(before, after))
    assert "the resources do not make a model: " in not_made(tmp_path / "damaged", fmi)[0]


# The end of the table


def test_halved_steps_reach_the_end_of_the_table_and_the_fmu_then_asks_for_the_end(unzipped):
    """Also if a discarded step is tried again."""
    with instance(unzipped[2], 2) as made:
        made.start(force_A=3.0).step(0.0, 1.0)
        for ended in (False, True):
            status, message = made.refused(made.step, 1.0, 100.0)
            assert status == DISCARD and "lower force_A, now 3, or export" in message
            assert made.fmu.getRealStatus(fmi2LastSuccessfulTime) == 1.0 == made.get("time")[0]
            assert made.fmu.getBooleanStatus(fmi2Terminated) is ended
        time, step = 1.0, 50.0
        for _ in range(30):
            try:
                made.step(time, step)
                time += step
            except FMI_ERRORS:
                if made.fmu.getBooleanStatus(fmi2Terminated):
                    break
                step *= 0.5
        message = made.messages[-1][1]
        assert "however short the step" in message
        end = re.search(r"A_abs is ([\d.]+), the table ends at ([\d.]+)", message)
        assert 0.99 < float(end[1]) / float(end[2]) <= 1.0
        made.set(force_A=0.0)  # another input, and it goes on
        made.step(time, 1.0)
