"""What cannot be read, identified, predicted or fitted ends in one line that says what to do."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from measured.decays import BANDS, RATE, decay, decays, measurement, times
from measured.sine_tests import Oscillator, response_controlled
from measured.universal import FORCE, VELOCITY, write_uff

from slipmode import rom

T = np.arange(2000) / RATE
WAVE, Y = np.sin(160.0 * np.pi * T), np.cos(T)
DATA = measurement(decays(1, 2))
POINTS = rom.IdentifiedBackbone(
    mode=0,
    amplitude=np.array([1e-5, 1e-4]),
    frequency=np.array([172.0, 171.0]),
    damping=np.array([1e-3, 2e-3]),
    frequency_deviation=np.array([0.1, 0.1]),
    damping_deviation=np.array([1e-5, 1e-5]),
    unit="m",
)
JOINT = {"a": (rom.Jenkins(1.0, 1e4), [0])}


def identify(signals=None, bands=BANDS, rate=RATE, **options):
    rom.identify(DATA if signals is None else measurement(signals, rate), bands=bands, **options)


@cache
def found(unit="m/s"):
    return rom.identify(measurement(decays(1, 1), unit=unit), bands=BANDS, law="linear")


@cache
def sine(*amplitudes, unit="m/s^2"):
    tests = [response_controlled(Oscillator(), a, np.linspace(77.5, 82.0, 46)) for a in amplitudes]
    return rom.SineTests(tests, unit)


def identify_sine(amplitudes=(10, 30, 50, 70), unit="m/s^2", band=(77.0, 83.0), **options):
    return rom.identify_sine(sine(*amplitudes, unit=unit), band=band, **options)


def predict_sine(*amplitudes, unit="m/s^2", **options):
    known = identify_sine((10, 30), law="linear")
    known.predict(sine(*amplitudes, unit=unit), band=(77.0, 83.0), **options)


def fit(backbones=None, groups=JOINT, structure=None, **options):
    free = rom.Structure(np.eye(2), np.diag([2e4, 1e6]), 1e-6, contact=[0])
    given = {"sensor": 0} | options
    rom.fit_contacts(structure or free, backbones or {0: POINTS}, groups, **given)


def read(name, **options):
    rom.read_measurement(name, **({"quantity": "x", "unit": "m/s"} | options))


def read_sine(name, **options):
    rom.read_sine_tests(name, **({"unit": "m/s^2", "force_unit": "N"} | options))


def read_loops(name, **options):
    rom.read_loops(name, **({"unit": "mm", "force_unit": "N"} | options))


def demodulate(force=WAVE, response=WAVE, rate=640.0):
    rom.demodulate_sine_test("a", force, response, rate)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Files, damaged and foreign ones."""
    path = tmp_path_factory.mktemp("files")
    (path / "b").mkdir()
    for name, text in {
        "table.csv": "1;2\n-3;4\n2;1\n", "b/table.csv": "1;2\n0;4\n",
        "times.csv": "time;x\n0.0;1\n1.0;2\n3.0;4\n", "e.csv": "",
        "binary.csv": "time,a\n0,1\n\0\0\0", "e.wav": "RIFF",
        "torque.csv": "frequency,torque,amplitude,phase\n1,2,3,0.1\n2,2,3,0.2\n",
        "sine.csv": "frequency,force,amplitude,phase\n79,1,2,0\n80,1,2,-1\n",
        "volt.csv": "frequency,force [V],amplitude,phase\n79,1,2,0\n80,1,2,-1\n",
        "degrees.csv": "frequency,force,amplitude,phase\n79,1,2,-6\n80,1,2,-170\n",
    }.items():  # fmt: skip
        (path / name).write_text(text)
    np.savez(path / "hit.npz", hit=np.stack([Y, Y]), fs=RATE)
    np.savez(path / "no_rate.npz", force=WAVE, response=WAVE)
    F, v, other = (1, FORCE, "N", WAVE), (1, VELOCITY, "m/s", WAVE), (2, VELOCITY, "m/s", WAVE)
    write_uff(path / "nodes.uff", [v, other, v], RATE)
    write_uff(path / "two.uff", [v, F, other], RATE)
    return path


GIVEN = [  # a call, and what the message contains
    (lambda: identify(law="linear", cross=True), "cross: a linear law has no cross effects"),
    (lambda: identify(law="jenkins"), "bands: law = jenkins is a law of one mode; give one band"),
    (lambda: identify(bands=BANDS[:1], law="quadratic"), "bands: cross effects and quadratic cou"),
    (lambda: identify(bands=[(150, 200)]), "bands: 150 to 200 Hz has no decay of a mode"),
    (lambda: identify(bands=[(100, 260)]), "bands: 100 to 260 Hz has peaks at"),
    (lambda: identify(bands=[(100, 140), (130, 260)]), "must not overlap"),
    (lambda: identify([decay(np.random.default_rng(1), t=times(rate=300.0))], BANDS[:1], 300.0),
     "bands: 140 Hz needs a sampling rate of at least 350"),
    (lambda: identify([np.minimum(y, 0.7 * y.max()) for y in decays(2, 2)]),
     "no record can be fitted (hit1: it is clipped"),
    (lambda: identify(decays(2, 1, t=times(0.6), noise=0.01, start=(1.0, 0.1)), law="quadratic",
                      cross=True), "law = quadratic with cross effects: has 16"),
    (lambda: found().predict(rom.Record("x", np.zeros((1, 5000)), RATE)), "the signal is constan"),
    (lambda: found().predict(rom.Record("loud", 9.0 * DATA[1].signal, RATE)), "loud: mode A star"),
    (lambda: found().model(mode_shape=[0.0, 1.0]), "mode_shape = [0.0, 1.0]: must be one number"),
    (lambda: found("V").model(), "unit = 'V': must be m, m/s, m/s^2"),
    (lambda: demodulate(WAVE[:200], WAVE[:200]), "a is too short. It is driven for 200 samples a"),
    (lambda: demodulate(*np.random.default_rng(2).standard_normal((2, 4000))), "a is not a sine"),
    (lambda: identify_sine(band=(83.0, 77.0)), "band = (83.0, 77.0): must be 0 < lower < upper e"),
    (lambda: identify_sine((10, 30, 50)), "must have at least 4 levels for a power law, got 3"),
    (lambda: predict_sine(200), "is beyond the largest measured"),
    (lambda: fit(POINTS), "backbones: must be {mode: rom.IdentifiedBackbone}"),
    (lambda: fit({0: replace(POINTS, damping_deviation=np.full(2, np.inf))}), "three records"),
    (lambda: fit(adjust=("damping", "frequency"),
                 groups={"a": (rom.Iwan(1.0, 1e4, 0.0, 1.0), [0])}),
     "4 values do not determine 6 parameters"),
    (lambda: fit(sensor=1), "sensor = 1: mode 0 does not move this DOF"),
    (lambda: fit(groups={"a": (rom.Tanh(1.0, 1.0), [0])}), "groups: 'a' must be"),
    (lambda: fit(groups={"a": (rom.FrictionalContact(0.4, 0.5, tangential_stiffness=4e3,
                                                     normal_stiffness=5e3), [0])}), "rom.Jenkins"),
]  # fmt: skip
FILES = [
    (read, "e.csv", {}, "e.csv"),
    (read, "e.wav", {}, "e.wav"),
    (read, "binary.csv", {}, "is damaged: line 3 has the control character"),
    (read, "times.csv", {}, "times must rise in equal steps"),
    (read, "table.csv", {"unit": None, "sample_rate": 1.0}, "give unit=, such as 'm/s'"),
    (read, "hit.npz", {"channels": ["tip"]}, "has channel 0, channel 1, not 'tip'"),
    (read, "nodes.uff", {}, "choose common ones by channels="),
    (read_sine, "torque.csv", {}, "got frequency, torque, amplitude, phase; the"),
    (read_sine, "sine.csv", {"force_unit": None}, "does not state one; give force_unit="),
    (read_sine, "volt.csv", {"force_unit": None}, "force is in 'V': must be N"),
    (read_sine, "degrees.csv", {}, "phase reaches 170 and has no unit; write phase"),
    (read_sine, "no_rate.npz", {}, "has neither a sampling rate nor times; give sample_rate="),
    (read_sine, "two.uff", {}, "choose one"),
    (read_loops, "no_rate.npz", {"unit": None}, "does not state one; give unit="),
    (read_loops, "no_rate.npz", {"force_unit": None}, "does not state one; give force_unit="),
    (read_loops, "hit.npz", {}, "must have one displacement and one force, got channel 0, chan"),
]


def refused(call, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        call()
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("call", "message"), GIVEN, ids=[message[:40] for _, message in GIVEN])
def test_a_call_that_cannot_be_answered_is_refused(call, message):
    refused(call, message)


@pytest.mark.parametrize(("reader", "name", "options", "message"), FILES)
def test_a_file_that_cannot_be_read_is_refused(reader, name, options, message, folder):
    refused(lambda: reader(str(folder / name), **options), message)


def test_records_of_one_name_are_refused(folder):
    files = [folder / "table.csv", folder / "b" / "table.csv"]
    refused(lambda: read(files, sample_rate=1.0), "records table occur more than once")
