"""Files with sine tests."""

import numpy as np
import pytest
import scipy.io
from measured import universal
from measured.sweeps import RATE, JointedOscillator, sweep

from slipmode import rom

FREQUENCY = np.array([79.0, 80.0, 81.0])
FORCE, AMPLITUDE, PHASE = np.array([1.0, 0.5, 1.5]), np.full(3, 20.0), np.array([-0.1, -1.6, -3.0])
COLUMNS = np.stack([FREQUENCY, FORCE, AMPLITUDE, PHASE], axis=1)
ARRAYS = dict(zip(("frequency", "force", "amplitude", "phase"), COLUMNS.T.copy(), strict=True))


def write_csv(path, header="frequency,force,amplitude,phase"):
    np.savetxt(path, COLUMNS, delimiter=",", header=header, comments="")


def check(test):
    assert test.frequency.tolist() == FREQUENCY.tolist()
    assert test.force.tolist() == FORCE.tolist()
    assert test.response == pytest.approx(AMPLITUDE * np.exp(1j * PHASE))


def test_text_files_are_tests_in_natural_order(tmp_path):
    for k in (2, 10):
        write_csv(tmp_path / f"level{k}.csv")
    found = rom.read_sine_tests(tmp_path / "level*.csv", unit="m/s^2", force_unit="N")
    assert [test.name for test in found] == ["level2", "level10"]
    assert found.unit == "m/s^2"
    for test in found:
        check(test)


def test_units_may_stand_in_the_header(tmp_path):
    write_csv(tmp_path / "a.csv", "frequency [Hz],force (N),amplitude [m/s],phase [rad]")
    found = rom.read_sine_tests(tmp_path / "a.csv")
    assert found.unit == "m/s"
    check(found.tests[0])


def test_arrays_and_structures_are_read(tmp_path):
    np.savez(tmp_path / "a.npz", **ARRAYS)
    check(rom.read_sine_tests(tmp_path / "a.npz", unit="m", force_unit="N").tests[0])
    fields = ARRAYS | {"units": "Hz, N, m/s^2, rad"}
    scipy.io.savemat(tmp_path / "b.mat", {"data": {"up": [fields, fields], "down": fields}})
    found = rom.read_sine_tests(tmp_path / "b.mat")
    assert len(found["up"]) == 2
    assert [test.name for test in found["down"]] == ["down"]
    assert found.unit == "m/s^2"
    check(found["up"].tests[1])
    with pytest.raises(rom.SlipmodeError, match="tests: no name starts with 'left'"):
        found["left"]


@pytest.mark.parametrize(
    ("header", "arguments", "message"),
    [
        ("frequency,torque,amplitude,phase", {}, "got frequency, torque, amplitude, phase; the"),
        ("frequency,force,amplitude,phase", {"unit": None}, "unit: .* does not state one"),
        ("frequency,force,amplitude,phase", {"force_unit": None}, "force_unit: .* does not state"),
        (
            "frequency,force [V],amplitude,phase",
            {"force_unit": None},
            "force is in 'V': must be N",
        ),
        ("frequency,force,amplitude,phase [V]", {}, "phase is in 'V': must be a unit of angle"),
        ("frequency,force,amplitude,phase", {"unit": "V"}, "unit = 'V': must be m, m/s, m/s"),
    ],
)
def test_files_without_a_force_or_unit_are_refused(tmp_path, header, arguments, message):
    write_csv(tmp_path / "a.csv", header)
    given = {"unit": "m/s^2", "force_unit": "N"} | arguments
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.read_sine_tests(tmp_path / "a.csv", **given)


@pytest.mark.parametrize(
    ("response", "unit", "size"),
    [
        ("m/s^2", "m/s^2", 1.0),
        ("m/s²", "m/s^2", 1.0),
        ("m/s2", "m/s^2", 1.0),
        ("g", "m/s^2", 9.80665),
        ("mm / s^2", "m/s^2", 1e-3),
        ("MM/S", "m/s", 1e-3),
        ("µm", "m", 1e-6),
    ],
)
def test_units_are_converted(response, unit, size, tmp_path):
    header = f"Frequency (Hz),Force (kN),Amplitude ({response}),Phase (deg)"
    table = COLUMNS / [1.0, 1e3, size, np.pi / 180.0]
    np.savetxt(
        tmp_path / "a.csv", table, delimiter=",", header=header, comments="", encoding="utf-8"
    )
    found = rom.read_sine_tests(tmp_path / "a.csv")
    assert found.unit == unit
    (test,) = found
    assert test.force == pytest.approx(FORCE)
    assert test.response == pytest.approx(AMPLITUDE * np.exp(1j * PHASE))


def test_a_given_unit_overrides_the_file_with_a_note(tmp_path):
    write_csv(tmp_path / "a.csv", "frequency,force [N],amplitude [V],phase")
    (test,) = rom.read_sine_tests(tmp_path / "a.csv", unit="mm/s")
    assert test.response == pytest.approx(1e-3 * AMPLITUDE * np.exp(1j * PHASE))
    assert test.notes == ("amplitude is in mm/s as given; the file states V",)


def test_degrees_without_unit_are_refused(tmp_path):
    np.savez(tmp_path / "a.npz", **(ARRAYS | {"phase": [-6.0, -90.0, -170.0]}))
    with pytest.raises(rom.SlipmodeError, match=r"phase reaches 170 and has no unit; write phase"):
        rom.read_sine_tests(tmp_path / "a.npz", unit="m", force_unit="N")


def test_columns_of_several_lengths_are_refused(tmp_path):
    np.savez(tmp_path / "a.npz", **(ARRAYS | {"phase": PHASE[1:]}))
    with pytest.raises(
        rom.SlipmodeError, match="frequency, force, amplitude, phase must have one"
    ):
        rom.read_sine_tests(tmp_path / "a.npz", unit="m", force_unit="N")


SWEEP = sweep(78.0, 81.4, 0.5, 0.4)
FORCE_SIGNAL, VELOCITY = JointedOscillator().signals(*SWEEP)
TIMES = np.arange(1, VELOCITY.size + 1) / RATE
EXPECTED = rom.demodulate_sine_test("x", FORCE_SIGNAL, VELOCITY, RATE)


def check_signals(test):
    assert test.frequency == pytest.approx(EXPECTED.frequency, rel=1e-5)
    assert test.force == pytest.approx(EXPECTED.force, abs=1e-3)
    assert np.abs(test.response) == pytest.approx(np.abs(EXPECTED.response), abs=1e-4)


def test_time_signals_are_read(tmp_path):
    table = np.stack([TIMES, FORCE_SIGNAL, VELOCITY], axis=1)
    header = "time [s],force [N],response [m/s]"
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header=header, comments="")
    fields = {"force": FORCE_SIGNAL, "response": VELOCITY, "sample_rate": RATE}
    np.savez(tmp_path / "b.npz", **fields)
    timed = {"time": TIMES, "F1": FORCE_SIGNAL, "v2": VELOCITY, "units": "s, N, m/s"}
    scipy.io.savemat(tmp_path / "c.mat", {"data": {"up": fields}})
    scipy.io.savemat(tmp_path / "d.mat", timed)
    header = "t [ms];F [kN];v [mm/s]"  # the force is known by its unit
    scaled = table * [1e3, 1e-3, 1e3]
    np.savetxt(tmp_path / "e.csv", scaled, "%.9g", ";", header=header, comments="")
    units = {"unit": "m/s", "force_unit": "N"}
    for found in (
        rom.read_sine_tests(tmp_path / "a.csv"),
        rom.read_sine_tests(tmp_path / "e.csv"),
        rom.read_sine_tests(tmp_path / "b.npz", **units),
        rom.read_sine_tests(tmp_path / "c.mat", **units),
        rom.read_sine_tests(tmp_path / "d.mat", channels=("F1", "v2")),
    ):
        assert found.unit == "m/s"
        check_signals(found.tests[0])
    assert rom.read_sine_tests(tmp_path / "c.mat", **units).tests[0].name == "up"


@pytest.mark.parametrize(
    ("names", "arguments", "message"),
    [
        (("time", "response"), {}, "or the time signals force, response, got time, response; the"),
        (("force", "response"), {}, "has neither a sampling rate nor times; give sample_rate="),
        (("time", "force", "response"), {"unit": None}, "unit: .* does not state one; give unit="),
        (("time", "force", "response"), {"force_unit": None}, "force_unit: .* does not state"),
        (("time", "force", "response"), {"sample_rate": -1.0}, "sample_rate = -1.0: must be > 0"),
        (
            ("time", "force", "response"),
            {"channels": ("F", "x")},
            "must have F, x, got time, force",
        ),
        (("time", "force", "response"), {"channels": "force"}, "channels = 'force': must be the"),
    ],
)
def test_time_signals_without_force_unit_or_rate_are_refused(tmp_path, names, arguments, message):
    arrays = {"time": TIMES, "force": FORCE_SIGNAL, "response": VELOCITY}
    np.savez(tmp_path / "a.npz", **{name: arrays[name] for name in names})
    given = {"unit": "m/s", "force_unit": "N"} | arguments
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.read_sine_tests(tmp_path / "a.npz", **given)


def test_universal_files_have_signals(tmp_path):
    force, velocity = (1, universal.FORCE, "N", FORCE_SIGNAL), (1, 11, "m/s", VELOCITY)
    other = (2, 11, "m/s", 0.5 * VELOCITY)
    universal.write_uff(tmp_path / "a.uff", [force, velocity] * 2, RATE)
    found = rom.read_sine_tests(tmp_path / "a.uff")
    assert [test.name for test in found] == ["a_1", "a_2"]
    assert found.unit == "m/s"
    check_signals(found.tests[1])
    universal.write_uff(tmp_path / "b.uff", [velocity, force, other], RATE)
    words = "b has the forces force 1:.3 and the responses 1:.3, 2:.3; choose one .* channels="
    with pytest.raises(rom.SlipmodeError, match=words):
        rom.read_sine_tests(tmp_path / "b.uff")
    check_signals(
        rom.read_sine_tests(tmp_path / "b.uff", channels=("force 1:+3", "1:+3")).tests[0]
    )
    with pytest.raises(rom.SlipmodeError, match=r"channels: .* has 1:\+3, .*, not '3:\+3'"):
        rom.read_sine_tests(tmp_path / "b.uff", channels=("force 1:+3", "3:+3"))
    universal.write_uff(tmp_path / "c.uff", [velocity], RATE)
    with pytest.raises(rom.SlipmodeError, match=r"c has the forces none and the responses 1:.3"):
        rom.read_sine_tests(tmp_path / "c.uff")
    universal.write_uff(tmp_path / "d.uff", [(1, 13, "", FORCE_SIGNAL), velocity], RATE)
    with pytest.raises(rom.SlipmodeError, match=r"force_unit: .*d.uff does not state one"):
        rom.read_sine_tests(tmp_path / "d.uff")
    check_signals(rom.read_sine_tests(tmp_path / "d.uff", force_unit="N").tests[0])
    universal.write_uff(tmp_path / "e.uff", [force, velocity], RATE, function=4)
    with pytest.raises(rom.SlipmodeError, match="has no time signals in data sets 58"):
        rom.read_sine_tests(tmp_path / "e.uff")


def test_other_files_are_refused(tmp_path):
    (tmp_path / "a.wav").write_text("")
    with pytest.raises(rom.SlipmodeError, match=r"the name must end in .csv, .txt, .*, .mat"):
        rom.read_sine_tests(tmp_path / "a.wav", unit="m", force_unit="N")
    with pytest.raises(rom.SlipmodeError, match="files: there is no file"):
        rom.read_sine_tests(tmp_path / "b.csv", unit="m", force_unit="N")
