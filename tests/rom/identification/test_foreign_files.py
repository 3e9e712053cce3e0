"""Records as loggers, oscilloscopes and other programs store them: units, times, channels."""

import numpy as np
import pytest
import scipy.io
from measured.universal import VELOCITY, write_uff

from slipmode import rom

RATE = 2000.0
T = np.arange(200) / RATE
Y = np.random.default_rng(5).standard_normal((2, T.size)).round(5)


def read(path, **options):
    return rom.read_measurement(path, **({"quantity": "x", "unit": "m/s^2"} | options))


def write(path, head, row, tail="", encoding="utf-8"):
    rows = [row(t, *y) for t, y in zip(T, Y.T, strict=True)]
    path.write_text("\r\n".join([*head, *rows, tail]), encoding=encoding, newline="")


def comma(x):
    return f"{x:.5f}".replace(".", ",")


LVM = ["LabVIEW Measurement", "Separator\tTab", "***End_of_Header***", "", "Channels\t2"]
LVM += ["Samples\t200\t200", "Y_Unit_Label\tg\tg", "Delta_X\t0.0005\t0.0005"]
LVM += ["***End_of_Header***", "X_Value\ta\tb\tComment"]
DIALECTS = {
    "decimal comma": (["Zeit;a;b"], lambda t, a, b: f"{comma(t)};{comma(a)};{comma(b)}", None),
    "row of units": (["Time,a,b", "s,g,g"], lambda t, a, b: f"{t:.5f},{a:.5f},{b:.5f}", "g"),
    "picoscope": (
        ["Time,a,b", "(ms),(V),(V)", ""],
        lambda t, a, b: f"{1e3 * t:.5f},{a:.5f},{b:.5f}",
        "V",
    ),
    "quoted": (['"time","a","b"'], lambda t, a, b: f'"{t:.5f}","{a:.5f}","{b:.5f}"', None),
    "quoted decimal comma": (
        ['"time","a","b"'],
        lambda t, a, b: f'"{comma(t)}","{comma(a)}","{comma(b)}"',
        None,
    ),
    "labview": (LVM, lambda t, a, b: f"{t:.5f}\t{a:.5f}\t{b:.5f}\t", "g"),
    "microseconds": (["t [µs];a;b"], lambda t, a, b: f"{1e6 * t:.0f};{a:.5f};{b:.5f};", None),
    "times of day": (
        ["Date\tTime\ta\tb"],
        lambda t, a, b: (
            f"2024-03-01\t23:59:{59.95 + t:.4f}\t{a:.5f}\t{b:.5f}"
            if t < 0.0499
            else f"2024-03-02\t00:00:{t - 0.05:07.4f}\t{a:.5f}\t{b:.5f}"
        ),
        None,
    ),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_are_read(dialect, encoding, tmp_path):
    head, row, stated = DIALECTS[dialect]
    write(tmp_path / "hit.csv", head, row, encoding=encoding)
    found = read(tmp_path / "hit.csv")
    assert found.channels == ("a", "b")
    assert found.unit == "m/s^2"
    (record,) = found
    assert record.sample_rate == pytest.approx(RATE, rel=1e-6)
    np.testing.assert_array_equal(record.signal, Y)
    assert len(record.notes) == 2 * bool(stated)
    assert all(f"is in m/s^2 as given; the file states {stated}" in n for n in record.notes)


def test_damage_is_named(tmp_path):
    path = tmp_path / "hit.csv"
    row = "{:.5f},{:.5f},{:.5f}".format
    write(path, ["Samples,500", "time,a,b"], row, tail="0.1000,0.")
    assert read(path).records[0].notes == (
        "its last line, 203, is incomplete and was left out",
        "it states 500 samples and has 200",
    )
    for tail in ("0.1,x,1", "time,a,b\r\n0.1,1,2"):
        write(path, ["time,a,b"], row, tail=tail)
        with pytest.raises(rom.SlipmodeError, match="line 202 must have one number a column"):
            read(path)
    path.write_bytes(b"time,a\n0,1\n" + bytes(40))
    with pytest.raises(rom.SlipmodeError, match=r"is damaged: line 3 has the control character"):
        read(path)


@pytest.mark.parametrize("form", ["%.4f", "%.5g", "%.4e"])
def test_rounded_times_are_even(form, tmp_path):
    rate = 2048.0
    t = np.arange(4096) / rate
    table = np.column_stack([t, np.cos(t)])
    np.savetxt(tmp_path / "hit.csv", table, [form, "%.5f"], ",", header="time,a", comments="")
    (record,) = read(tmp_path / "hit.csv")
    assert record.sample_rate == pytest.approx(rate, rel=1e-5)
    assert record.notes == ()
    lost = np.delete(table, 2000, axis=0)
    np.savetxt(tmp_path / "hit.csv", lost, [form, "%.5f"], ",", header="time,a", comments="")
    with pytest.raises(rom.SlipmodeError, match=r"time \d+ is .* s off an even grid of 2047"):
        read(tmp_path / "hit.csv")
    (record,) = read(tmp_path / "hit.csv", sample_rate=rate)
    assert record.sample_rate == rate


def test_times_of_single_precision_are_even(tmp_path):
    t = (1000.0 + np.arange(4096) / 2048.3).astype(np.float32)
    np.savez(tmp_path / "hit.npz", time=t, acc=np.cos(t))
    assert read(tmp_path / "hit.npz").records[0].sample_rate == pytest.approx(2048.3, rel=1e-4)
    t[2000:] += 2.0 / 2048.3
    np.savez(tmp_path / "hit.npz", time=t, acc=np.cos(t))
    with pytest.raises(rom.SlipmodeError, match="times must rise in equal steps"):
        read(tmp_path / "hit.npz")


def test_one_file_per_blow_is_one_record(tmp_path):
    for k in (1, 2):
        arrays = {"time": T[:, None], "acc": k * Y[0][:, None], "Fs": RATE}
        scipy.io.savemat(tmp_path / f"hit{k}.mat", arrays)
        np.savez(tmp_path / f"hit{k}.npz", time=T, acc=k * Y.T)
    for ending, channels in ((".mat", ("acc",)), (".npz", ("channel 0", "channel 1"))):
        found = read(tmp_path / f"hit*{ending}")
        assert [record.name for record in found] == ["hit1", "hit2"]
        assert found.channels == channels
        np.testing.assert_array_equal(found["hit2"].signal, 2.0 * Y[: len(channels)])


def test_arrays_of_one_file_are_channels_or_records_with_a_note(tmp_path):
    np.savez(tmp_path / "hit.npz", time=T, tip=Y[0], root=Y[1])
    (record,) = found = read(tmp_path / "hit.npz")
    assert (record.name, found.channels) == ("hit", ("tip", "root"))
    assert "are channels of one record" in record.notes[0]
    np.savez(tmp_path / "hit.npz", time=T, acc1=Y[0], acc2=Y[1])
    found = read(tmp_path / "hit.npz")
    assert len(found) == 2 and "are records" in found.records[0].notes[0]
    found = read(tmp_path / "hit.npz", channels=["acc1", "acc2"])
    assert len(found) == 1 and found.channels == ("acc1", "acc2")


def data_sets(path, signals, **more):
    """Write signals given as (node, label, ID, time stamp, samples) without other names."""
    write_uff(path, [(node, VELOCITY, "g", y) for node, *_, y in signals], RATE)
    pyuff = pytest.importorskip("pyuff")
    sets = pyuff.UFF(str(path)).read_sets()
    path.unlink()
    for each, (_, label, name, stamp, _) in zip(sets, signals, strict=True):
        each |= {"ordinate_axis_lab": label, "id1": name, "id3": stamp, "rsp_dir": 0}
        pyuff.UFF(str(path)).write_sets(each, "add")


@pytest.mark.parametrize("by", ["node", "label", "id1"])
def test_sensors_of_one_blow_are_channels(by, tmp_path):
    signals = []
    for stamp in ("01-Mar-24 12:00:00", "01-Mar-24 12:01:00"):
        for k in (0, 1):
            own = {"node": k + 1, "label": f"a{k}", "id1": f"s{k}"}
            node, label, name = (own[key] if key == by else 0 for key in own)
            signals.append((node, label or "NONE", name or "NONE", stamp, Y[k]))
    names = {"node": ("1:+0", "2:+0"), "label": ("a0", "a1"), "id1": ("s0", "s1")}[by]
    data_sets(tmp_path / "two.uff", signals)
    data_sets(tmp_path / "one.uff", signals[:2])
    for name, records in (("two", ["two_1", "two_2"]), ("one", ["one"])):
        found = rom.read_measurement(tmp_path / f"{name}.uff", quantity="x")
        assert [record.name for record in found] == records
        assert found.channels == names
        np.testing.assert_allclose(found.records[-1].signal, Y, atol=1e-5)
        noted = "have one node and direction" in " ".join(found.records[0].notes)
        assert noted == (by != "node")


def test_a_truncated_data_set_has_a_note(tmp_path):
    write_uff(tmp_path / "hit.uff", [(1, VELOCITY, "g", Y[0])], RATE)
    lines = (tmp_path / "hit.uff").read_bytes().splitlines(True)
    (tmp_path / "hit.uff").write_bytes(b"".join(lines[:33]) + b"    -1\n")
    (record,) = rom.read_measurement(tmp_path / "hit.uff", quantity="x")
    assert record.notes == (f"1:+3 states 200 samples and has {record.samples}",)
    twice = b"".join(lines) + b"".join(lines[:33])
    (tmp_path / "hit.uff").write_bytes(twice)
    (record,) = rom.read_measurement(tmp_path / "hit.uff", quantity="x")
    assert record.samples == 200
    assert record.notes == ("the file ends within a data set, which was left out",)
