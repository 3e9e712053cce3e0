"""FMUs in FMPy against the component; state, step patterns, threads, refusals."""

import ctypes
import shutil
import subprocess
import sys
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import quote

import fmpy
import numpy as np
import pytest
from fmu_fixtures import START, VERSIONS, Instance, component, instance

from slipmode import fmu
from slipmode.fmu.archive.resources import FORMAT
from slipmode.fmu.inputs import place

pytestmark = pytest.mark.quick

SUPPORT = Path(__file__).parents[1] / "support"
FMI_ERRORS = fmpy.fmi1.FMICallException
SLOW = ("A_re", "A_im", "B_re", "B_im", "theta_A", "theta_B", "dissipated_energy")
FAST = ("contact_0_x", "contact_1_v", "contact_0_f", "x_0", "x_1")


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def test_co_simulation_has_the_components_bits(fmus, fmi, two_mode_model):
    stepped = component(two_mode_model)
    rows = [stepped.outputs()]
    for k in range(200):
        stepped.do_step(k * 1.0, 1.0)
        rows.append(stepped.outputs())
    names = [name for name in stepped.output_names if name != "time"]
    result = fmpy.simulate_fmu(
        fmus[fmi], stop_time=200.0, output_interval=1.0, fmi_type="CoSimulation", output=names
    )
    assert result.size == 201
    for name in names:
        np.testing.assert_array_equal(result[name], [row[name] for row in rows], err_msg=name)


def test_moving_inputs_have_the_components_bits(unzipped, fmi, two_mode_model):
    """Sweeps and ramps, and one input set while the others go on moving."""
    moving = {"frequency_rate_A": 1.3e-4, "force_rate_B": -7e-4, "phase_rate_A": 3e-3}
    stepped = component(two_mode_model)
    stepped.set_inputs(**moving)
    with instance(unzipped[fmi], fmi) as made:
        made.start(**START, **moving)
        time = 0.0
        for k, duration in enumerate((3.7, 0.1, 11.3, 1 / 3, 20.0)):
            stepped.set_inputs(phase_B=0.1 * k)
            made.set(phase_B=0.1 * k)
            stepped.do_step(time, duration)
            made.step(time, duration)
            time = stepped.time
            expected = stepped.outputs()
            assert list(made.get(*SLOW, *FAST)) == [expected[name] for name in SLOW + FAST]
            assert made.get("force_B")[0] == stepped._inputs[0, place("force", 1)]


def test_fmi2_input_derivatives_are_rates(unzipped):
    with instance(unzipped[2], 2) as one, instance(unzipped[2], 2) as other:
        one.start(force_rate_A=1e-3).step(0.0, 10.0)
        other.start()
        other.fmu.setRealInputDerivatives([other.reference["force_A"]], [1], [1e-3])
        other.step(0.0, 10.0)
        np.testing.assert_array_equal(one.get(*SLOW), other.get(*SLOW))
        assert other.get("force_A")[0] == pytest.approx(START["force_A"] + 1e-2)


def test_model_exchange_agrees_with_co_simulation(fmus, fmi):
    common = {"stop_time": 150.0, "output_interval": 1.0, "output": (*SLOW, *FAST)}
    stepped = fmpy.simulate_fmu(
        fmus[fmi],
        fmi_type="CoSimulation",
        start_values={"tolerance": 1e-9},
        relative_tolerance=1e-9,  # at initialisation FMPy sets one of its own in FMI 3
        **common,
    )
    solved = fmpy.simulate_fmu(
        fmus[fmi], fmi_type="ModelExchange", relative_tolerance=1e-9, **common
    )
    for name in SLOW:
        np.testing.assert_allclose(solved[name], stepped[name], atol=1e-6, err_msg=name)
    for name in FAST:  # on amplitudes that are straight lines, marched in other steps
        scale = np.abs(stepped[name]).max()
        apart = 0.03 if name.endswith("_v") else 0.005  # measured 0.026, 0.0046
        np.testing.assert_allclose(solved[name], stepped[name], atol=apart * scale, err_msg=name)


def test_the_friction_limit_follows_its_input(scalable, fmi, coulomb_model):
    """Limits and forces twice as large: amplitudes twice as large."""
    ends = []
    for scale in (1.0, 2.0):
        with instance(scalable[fmi], fmi) as made:
            made.start(force_A=0.1 * scale, force_B=0.1 * scale, limit_scale=scale)
            made.step(0.0, 100.0)
            ends.append(made.get("A_re", "A_im", "B_re", "B_im") / scale)
            with pytest.raises(FMI_ERRORS):
                made.set(limit_scale=0.0)
            assert "limit_scale: must be > 0, got 0" in made.messages[-1][1]
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-4)


def test_results_do_not_depend_on_the_steps(unzipped, fmi):
    """Steps of 0.01 to 100 s to the same time; each may be off by the internal tolerance.

    On 56 x 67 nodes long steps cross many cells: the sum is 4.2e-7, at a tolerance of 1e-6 1.6e-6.
    """
    ends = []
    for duration in (0.01, 0.1, 1.0, 10.0, 100.0):
        with instance(unzipped[fmi], fmi) as made:
            made.start(tolerance=1e-7)
            for k in range(round(100.0 / duration)):
                made.step(k * duration, duration)
            ends.append(made.get("A_re", "A_im", "B_re", "B_im"))
    largest = np.abs(ends).max()
    np.testing.assert_allclose(ends, np.broadcast_to(ends[0], (5, 4)), atol=1e-6 * largest)


def test_a_saved_state_continues_to_the_same_bits(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made, instance(unzipped[fmi], fmi) as twin:
        made.start(force_rate_A=1e-4).step(0.0, 33.3)
        saved = made.serialize()
        twin.start(A_re=0.5).step(0.0, 5.0)  # a past to be forgotten
        twin.restore(saved)
        assert twin.serialize() == saved
        for time, duration in ((33.3, 1.1), (34.4, 20.0)):
            made.step(time, duration)
            twin.step(time, duration)
            np.testing.assert_array_equal(made.get(*SLOW, *FAST), twin.get(*SLOW, *FAST))
        made.restore(saved)
        made.step(33.3, 1.1)
        made.step(34.4, 20.0)
        np.testing.assert_array_equal(made.get(*SLOW, *FAST), twin.get(*SLOW, *FAST))


_CONTINUE = """
import sys
from fmu_fixtures import instance
folder, fmi, saved, names = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4:]
with instance(folder, fmi) as made:
    made.restore(bytes.fromhex(saved))
    made.step(33.3, 17.0)
    print(*(value.hex() for value in made.get(*names).tolist()))
"""


def test_a_state_continues_in_another_process(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start().step(0.0, 33.3)
        saved = made.serialize().hex()
        done = subprocess.run(
            [sys.executable, "-c", _CONTINUE, str(unzipped[fmi]), str(fmi), saved, *SLOW, *FAST],
            cwd=SUPPORT,
            capture_output=True,
            text=True,
            check=True,
        )
        made.step(33.3, 17.0)
        there = [float.fromhex(word) for word in done.stdout.split()]
        assert there == made.get(*SLOW, *FAST).tolist()


def test_a_state_of_another_model_is_refused(unzipped, fmi, tmp_path, one_mode_model):
    path = fmu.export(one_mode_model, tmp_path / "other.fmu", ({0: 1.0},), fmi=fmi)
    shutil.unpack_archive(path, tmp_path / "other", format="zip")
    with instance(unzipped[fmi], fmi) as made, instance(tmp_path / "other", fmi) as other:
        saved = made.start().serialize()
        with pytest.raises(FMI_ERRORS):
            other.restore(saved + bytes(1000))
        assert "another model" in other.messages[-1][1]
        with pytest.raises(FMI_ERRORS):
            made.restore(saved[:-1])
        assert "too few" in made.messages[-1][1]


def test_reset_starts_anew(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start(A_re=0.3, damping_A=0.02).step(0.0, 20.0)
        made.fmu.reset()
        made.start().step(0.0, 20.0)
        again = made.get(*SLOW)
    with instance(unzipped[fmi], fmi) as fresh:
        fresh.start().step(0.0, 20.0)
        np.testing.assert_array_equal(again, fresh.get(*SLOW))


def test_start_values_take_effect(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start(time=5.0, A_re=0.3, A_im=-0.4, B_re=0.1)
        assert made.get("time", "A_re", "A_im", "A_abs", "A_phase", "B_re").tolist() == [
            *(5.0, 0.3, -0.4, 0.5, np.arctan2(-0.4, 0.3), 0.1)
        ]
        made.step(5.0, 1.0)
        assert made.get("time")[0] == 6.0


def test_modal_damping_is_a_parameter_also_below_zero(unzipped, fmi):
    """A self-excited mode, as flutter makes it, grows until the contacts slip."""
    damped = []
    for damping in (0.01, 0.1, -0.02):
        with instance(unzipped[fmi], fmi) as made:
            made.start(A_re=0.5, force_A=0.0, damping_A=damping).step(0.0, 20.0)
            damped.append(made.get("A_abs")[0])
    assert damped[1] / damped[0] == pytest.approx(np.exp(-0.5 * 0.09 * 20.0), rel=0.02)
    assert damped[2] / damped[0] == pytest.approx(np.exp(0.5 * 0.03 * 20.0), rel=0.02)


def test_a_decaying_amplitude_is_zero_before_its_square_is_denormal(scalable, fmi):
    """Denormal numbers cost a processor a hundred times as much as others."""
    found = []
    with instance(scalable[fmi], fmi) as made:
        made.start(A_re=1.0, force_A=0.0, force_B=0.0)
        for k in range(3000):  # 0.005 per second: 1e-308 after 140,000 s
            made.step(100.0 * k, 100.0)
            found.append(made.get("A_abs")[0])
    found = np.array(found)
    moving = found[found > 0.0]
    assert np.sqrt(np.finfo(float).tiny) < moving.min() < 1e-130
    assert 500 < moving.size < 2000
    assert not found[moving.size :].any()


def test_instances_in_threads_do_not_meet(unzipped, fmi):
    def simulate(force):
        with instance(unzipped[fmi], fmi) as made:
            made.start(force_A=force)
            for k in range(200):
                made.step(float(k), 1.0)
            return made.get(*SLOW, *FAST)

    forces = np.linspace(0.05, 0.2, 8)
    alone = [simulate(force) for force in forces]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(simulate, forces))
    np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize("exchange", [False, True])
def test_a_frequency_that_no_slow_flow_follows_is_refused(unzipped, fmi, exchange):
    with instance(unzipped[fmi], fmi, exchange=exchange) as made:
        made.start()
        if exchange:
            made.fmu.enterContinuousTimeMode()
        made.set(frequency_B=1.0)
        with pytest.raises(FMI_ERRORS) as refused:
            made.get("der(A_re)") if exchange else made.step(0.0, 1.0)
        assert refused.value.status == 3
        assert "frequency_B: must be 1.054 to 17 rad/s, got 1" in made.messages[-1][1]


def test_a_frequency_that_moves_too_far_is_refused(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start(frequency_rate_A=-0.01).step(0.0, 30.0)
        with pytest.raises(FMI_ERRORS) as refused:
            made.step(30.0, 10.0)
        assert refused.value.status == 3
        assert "frequency_A: must be 0.62 to 10 rad/s, got 0.58" in made.messages[-1][1]


MEET = "frequency_A, frequency_B: must differ at all times"


@pytest.mark.parametrize("exchange", [False, True])
def test_equal_frequencies_are_refused(unzipped, fmi, exchange):
    with instance(unzipped[fmi], fmi, exchange=exchange) as made:
        made.start()
        if exchange:
            made.fmu.enterContinuousTimeMode()
        made.set(frequency_A=1.5, frequency_B=1.5)
        with pytest.raises(FMI_ERRORS) as refused:
            made.get("der(A_re)") if exchange else made.step(0.0, 1.0)
        assert refused.value.status == 3
        assert MEET in made.messages[-1][1]


def test_frequencies_that_meet_on_the_way_are_refused(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start(frequency_A=1.25, frequency_rate_A=0.0125, frequency_B=1.5)
        with pytest.raises(FMI_ERRORS) as refused:
            made.step(0.0, 30.0)
        assert refused.value.status == 3
        assert MEET in made.messages[-1][1]


def test_the_edge_of_the_table_is_announced(unzipped, fmi):
    def status(made):
        references = [made.reference["table_status"]]
        getter = made.fmu.getInteger if fmi == 2 else made.fmu.getInt64
        return getter(references)[0]

    with instance(unzipped[fmi], fmi) as made:
        assert status(made.start(A_re=3.5)) == 1
    with instance(unzipped[fmi], fmi) as made:
        assert status(made.start(A_re=3.7)) == 2


def test_wrong_calls_are_refused_and_named(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start()

        def refuse(call, *arguments, reason, **named):
            with pytest.raises(FMI_ERRORS) as refused:
                call(*arguments, **named)
            assert refused.value.status == 3
            assert reason in made.messages[-1][1]

        refuse(made.step, 0.0, 0.0, reason="step 0 s: must be finite and > 0")
        refuse(made.step, 0.0, -1.0, reason="step -1 s")
        refuse(made.step, 0.0, np.nan, reason="step nan s")
        refuse(made.step, 3.0, 1.0, reason="t = 3 s: must be the present time of the FMU, 0 s")
        refuse(made.set, reason="force_A: must be finite, got nan", force_A=np.nan)
        refuse(made.set, reason="frequency_B: must be > 0", frequency_B=-1.0)
        refuse(made.set, reason="A_abs: is not an input or parameter", A_abs=1.0)
        refuse(made.set, reason="A_re: not allowed while the instance is in step mode", A_re=0.1)
        refuse(made.set, reason="tolerance: must be 1e-13 to 0.01, got 0.1", tolerance=0.1)
        refuse(made.fmu.exitInitializationMode, reason="ExitInitializationMode: not allowed")
        getter = made.fmu.getReal if fmi == 2 else made.fmu.getFloat64
        refuse(getter, [999], reason="value reference 999: there is no such variable")
        refuse(getter, [made.reference["contact_wanted"]], reason="contact_wanted: is a boolean")
        made.step(0.0, 1.0)
        made.fmu.terminate()
        refuse(made.step, 1.0, 1.0, reason="while the instance is terminated")


def test_refused_calls_have_the_names_of_their_version(unzipped, fmi):
    """Though both versions share the code of this call."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        call = ("getDerivatives", "getContinuousStateDerivatives")[fmi - 2]
        with pytest.raises(FMI_ERRORS):
            getattr(made.fmu, call)((ctypes.c_double * 7)(), 7)
        name = f"fmi{fmi}{call[0].upper()}{call[1:]}"
        refusal = f"{name}: not allowed while the instance is instantiated"
        assert made.messages[-1] == (3, refusal)


def test_steps_end_at_the_stop_time(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        if fmi == 2:
            made.fmu.setupExperiment(startTime=0.0, stopTime=1.0)
            made.fmu.enterInitializationMode()
        else:
            made.fmu.enterInitializationMode(startTime=0.0, stopTime=1.0)
        made.fmu.exitInitializationMode()
        for k in range(10):
            made.step(k * 0.1, 0.1)
        with pytest.raises(FMI_ERRORS):
            made.step(1.0, 0.1)
        assert "past the stop time" in made.messages[-1][1]


def test_a_wrong_token_is_refused(unzipped, fmi):
    messages = _refusal(unzipped[fmi], fmi, token="{not-the-token}")
    assert messages == [(3, "the instantiation token is not that of this FMU's resources")]


def _refusal(folder, fmi, **options):
    """The messages of an instance that is not made."""
    kept = []

    class Refused(Instance):
        def _instantiate(self):
            kept.append(self.messages)
            super()._instantiate()

    with pytest.raises(Exception, match="Failed to instantiate"):
        Refused(folder, fmi, **options)
    return kept[0]


def _instantiate2(folder, location):
    """Whether FMI 2.0 makes an instance from a resource location, and what it says."""
    made = Instance(folder, 2)
    try:
        messages = made.messages
        messages.clear()
        raw = made.fmu.fmi2Instantiate(
            b"raw",
            1,
            made.fmu.guid.encode(),
            location,
            ctypes.byref(made.fmu.callbacks),
            False,
            False,
        )
        if raw:
            made.fmu.fmi2FreeInstance(raw)
        return bool(raw), [message for _, message in messages]
    finally:
        made.free()


def test_fmi2_resource_locations_are_uris(unzipped):
    path = (unzipped[2] / "resources").as_posix()
    encoded = quote(path)
    assert "%20" in encoded and "%C3%BC" in encoded and "%25" in encoded
    for location in (
        *(
            f"file://{encoded}",
            f"file:{encoded}",
            f"file://localhost{encoded}",
            f"FILE://{encoded}/",
        ),
        *(path, f"{path}/"),  # some importers give the path itself
    ):
        assert _instantiate2(unzipped[2], location.encode()) == (True, [])
    for location, reason in (
        (f"http://{encoded}", "is not a file: URI"),
        (f"file://elsewhere{encoded}", "on another host"),
        (f"file://{encoded}%2", "two hexadecimal digits"),
        (f"file://{encoded}%00", "two hexadecimal digits"),
        ("", "no resource path was given"),
        (None, "no resource path was given"),
        ("file:///no/such/folder", "resources/token.txt is missing"),
    ):
        made, messages = _instantiate2(
            unzipped[2], None if location is None else location.encode()
        )
        assert not made
        assert reason in messages[-1], location


@pytest.mark.parametrize(
    ("name", "damage", "reason"),
    [
        ("table.npy", lambda path: path.unlink(), "table.npy is missing"),
        ("table.npy", lambda path: _cut(path, -8), "table.npy: it is truncated"),
        ("table.npy", lambda path: _flip(path, 5000), "table.npy: damaged, its checksum"),
        ("layout.npy", lambda path: _flip(path, 128), "layout.npy: damaged"),
        ("orders.npy", lambda path: _flip(path, 130), "orders.npy: damaged, its checksum"),
        (
            "contact_reaction.npy",
            lambda path: _cut(path, -8),
            "contact_reaction.npy: it is truncated",
        ),
        ("elastic_response.npy", lambda path: path.unlink(), "elastic_response.npy is missing"),
        ("names.txt", lambda path: _flip(path, 3), "names.txt: damaged"),
        ("node_a.npy", lambda path: _flip(path, 0), "node_a.npy: it is not an .npy file"),
    ],
)
def test_damaged_resources_are_refused_and_named(unzipped, fmi, tmp_path, name, damage, reason):
    folder = tmp_path / "damaged"
    shutil.copytree(unzipped[fmi], folder)
    damage(folder / "resources" / name)
    ((status, message),) = _refusal(folder, fmi)
    assert status == 3
    assert reason in message


@pytest.mark.parametrize("version", [FORMAT - 1, FORMAT + 1])
def test_resources_of_another_version_are_refused(unzipped, fmi, tmp_path, version):
    """Consistent in themselves, but not of the format that the library reads."""
    folder = tmp_path / "another"
    shutil.copytree(unzipped[fmi], folder)
    resources = folder / "resources"
    layout = np.load(resources / "layout.npy")
    layout[0] = version
    np.save(resources / "layout.npy", layout)
    checksums = np.load(resources / "checksums.npy")
    crc = zlib.crc32((resources / "layout.npy").read_bytes())
    checksums[0] = np.array([crc], dtype="<u4").view("<i4")[0]
    np.save(resources / "checksums.npy", checksums)
    ((_, message),) = _refusal(folder, fmi)
    assert f"layout.npy: version {version} must be {FORMAT} for this binary" in message


def _cut(path, end):
    path.write_bytes(path.read_bytes()[:end])


def _flip(path, at):
    content = bytearray(path.read_bytes())
    content[at] ^= 4
    path.write_bytes(content)
