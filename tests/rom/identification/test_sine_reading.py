"""Files of sine tests, as tables of responses or as time signals: the right values."""

import numpy as np
import pytest
import scipy.io
from measured import universal
from measured.sweeps import RATE, sweep

from slipmode import rom

COLUMNS = np.array([[79.0, 1.0, 20.0, -0.1], [80.0, 0.5, 20.0, -1.6], [81.0, 1.5, 20.0, -3.0]])
FREQUENCY, FORCE, AMPLITUDE, PHASE = COLUMNS.T
ARRAYS = dict(zip(("frequency", "force", "amplitude", "phase"), COLUMNS.T.copy(), strict=True))
UNITS = {"unit": "m/s^2", "force_unit": "N"}


def write_csv(path, header="frequency,force,amplitude,phase", table=COLUMNS):
    np.savetxt(
        path, table, delimiter=",", header=header, comments="", encoding="utf-8", fmt="%.12g"
    )


def check(test):
    assert test.frequency.tolist() == FREQUENCY.tolist()
    assert test.force == pytest.approx(FORCE)
    assert test.response == pytest.approx(AMPLITUDE * np.exp(1j * PHASE))


def test_text_files_are_tests_in_natural_order(tmp_path):
    for k in (2, 10):
        write_csv(tmp_path / f"level{k}.csv")
    found = rom.read_sine_tests(tmp_path / "level*.csv", **UNITS)
    assert [test.name for test in found] == ["level2", "level10"]
    assert found.unit == "m/s^2"
    for test in found:
        check(test)


@pytest.mark.parametrize(
    ("written", "unit", "size"),
    [("m/s²", "m/s^2", 1), ("g", "m/s^2", 9.80665), ("MM/S", "m/s", 1e-3), ("µm", "m", 1e-6)],
)
def test_units_are_converted(written, unit, size, tmp_path):
    header = f"Frequency (Hz),Force (kN),Amplitude ({written}),Phase (deg)"
    write_csv(tmp_path / "a.csv", header, COLUMNS / [1.0, 1e3, size, np.pi / 180.0])
    found = rom.read_sine_tests(tmp_path / "a.csv")
    assert found.unit == unit
    check(found.tests[0])


def test_a_given_unit_overrides_the_file_with_a_note(tmp_path):
    write_csv(tmp_path / "a.csv", "frequency,force [N],amplitude [V],phase")
    (test,) = rom.read_sine_tests(tmp_path / "a.csv", unit="mm/s")
    assert test.response == pytest.approx(1e-3 * AMPLITUDE * np.exp(1j * PHASE))
    assert test.notes == ("amplitude is in mm/s as given; the file states V",)


def test_arrays_and_structures_are_read(tmp_path):
    np.savez(tmp_path / "a.npz", **ARRAYS)
    check(rom.read_sine_tests(tmp_path / "a.npz", **UNITS).tests[0])
    fields = ARRAYS | {"units": "Hz, N, m/s^2, rad"}
    scipy.io.savemat(tmp_path / "b.mat", {"data": {"up": [fields, fields], "down": fields}})
    found = rom.read_sine_tests(tmp_path / "b.mat")
    assert len(found["up"]) == 2
    assert [test.name for test in found["down"]] == ["down"]
    assert found.unit == "m/s^2"
    check(found["up"].tests[1])
    with pytest.raises(rom.SlipmodeError, match="tests: no name starts with 'left'"):
        found["left"]


@pytest.fixture(scope="module")
def signals():
    """Times, force and velocity of a sweep, and the test that they are."""
    force, velocity = sweep(78.0, 81.4, 0.5, 0.4)
    expected = rom.demodulate_sine_test("x", force, velocity, RATE)
    return np.arange(1, velocity.size + 1) / RATE, force, velocity, expected


def test_time_signals_of_all_files_are_one_test(signals, tmp_path):
    time, force, velocity, expected = signals
    table = np.stack([time, force, velocity], axis=1)
    write_csv(tmp_path / "a.csv", "time [s],force [N],response [m/s]", table)
    header = "t [ms],F [kN],v [mm/s]"  # the force is known by its unit
    write_csv(tmp_path / "b.csv", header, table * [1e3, 1e-3, 1e3])
    fields = {"force": force, "response": velocity, "sample_rate": RATE}
    np.savez(tmp_path / "c.npz", **fields)
    scipy.io.savemat(tmp_path / "d.mat", {"data": {"up": fields}})
    timed = {"time": time, "F1": force, "v2": velocity, "units": "s, N, m/s"}
    scipy.io.savemat(tmp_path / "e.mat", timed)
    F, v = (1, universal.FORCE, "N", force), (1, 11, "m/s", velocity)
    other = (2, 11, "m/s", -force)
    universal.write_uff(tmp_path / "f.uff", [F, v], RATE)
    universal.write_uff(tmp_path / "g.uff", [v, F, other], RATE)
    universal.write_uff(tmp_path / "h.uff", [(1, universal.FORCE, "", force), v], RATE)
    units = {"unit": "m/s", "force_unit": "N"}
    for name, options in {
        "a.csv": {}, "b.csv": {}, "c.npz": units, "d.mat": units, "f.uff": {},
        "e.mat": {"channels": ("F1", "v2")}, "g.uff": {"channels": ("force 1:+3", "1:+3")},
        "h.uff": {"force_unit": "N"},
    }.items():  # fmt: skip
        found = rom.read_sine_tests(tmp_path / name, **options)
        (test,) = found
        assert found.unit == "m/s", name
        assert test.frequency == pytest.approx(expected.frequency, rel=1e-5), name
        assert test.force == pytest.approx(expected.force, abs=1e-3), name
        assert np.abs(test.response) == pytest.approx(np.abs(expected.response), abs=1e-4), name


def test_pairs_of_signals_in_a_universal_file_are_tests(signals, tmp_path):
    _, force, velocity, _ = signals
    pair = [(1, universal.FORCE, "N", force), (1, 11, "m/s", velocity)]
    universal.write_uff(tmp_path / "a.uff", pair * 2, RATE)
    assert [test.name for test in rom.read_sine_tests(tmp_path / "a.uff")] == ["a_1", "a_2"]
