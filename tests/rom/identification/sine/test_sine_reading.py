"""Files with sine tests."""

import numpy as np
import pytest
import scipy.io

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
        ("frequency,torque,amplitude,phase", {}, "has frequency, torque, amplitude, phase; the"),
        ("frequency,force,amplitude,phase", {"unit": None}, "unit: .* does not state one"),
        ("frequency,force,amplitude,phase", {"force_unit": None}, "force_unit: .* does not state"),
        ("frequency,force [kN],amplitude,phase", {"force_unit": None}, "is in 'kN': must be N"),
        ("frequency,force,amplitude,phase [deg]", {}, "phase is in 'deg': must be rad"),
        ("frequency,force,amplitude [m/s],phase", {}, "unit = 'm/s.2': .* states 'm/s'"),
        ("frequency,force,amplitude,phase", {"unit": "g"}, "unit = 'g': must be m, m/s, m/s"),
    ],
)
def test_files_without_a_force_or_unit_are_refused(tmp_path, header, arguments, message):
    write_csv(tmp_path / "a.csv", header)
    given = {"unit": "m/s^2", "force_unit": "N"} | arguments
    with pytest.raises(rom.SlipmodeError, match=message):
        rom.read_sine_tests(tmp_path / "a.csv", **given)


def test_columns_of_several_lengths_are_refused(tmp_path):
    np.savez(tmp_path / "a.npz", **(ARRAYS | {"phase": PHASE[1:]}))
    with pytest.raises(
        rom.SlipmodeError, match="frequency, force, amplitude, phase must have one"
    ):
        rom.read_sine_tests(tmp_path / "a.npz", unit="m", force_unit="N")


def test_other_files_are_refused(tmp_path):
    (tmp_path / "a.uff").write_text("")
    with pytest.raises(rom.SlipmodeError, match=r"the name must end in .csv, .txt, .npz, .mat"):
        rom.read_sine_tests(tmp_path / "a.uff", unit="m", force_unit="N")
    with pytest.raises(rom.SlipmodeError, match="files: there is no file"):
        rom.read_sine_tests(tmp_path / "b.csv", unit="m", force_unit="N")
