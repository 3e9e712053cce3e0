"""Files of decays as loggers, oscilloscopes and other programs store them: the right values."""

import numpy as np
import pytest
import scipy.io
from measured.universal import FORCE, VELOCITY, write_uff

from slipmode import rom

RATE = 2000.0
T = np.arange(200) / RATE
Y = np.random.default_rng(5).standard_normal((2, T.size)).round(5)


def read(path, **options):
    return rom.read_measurement(path, **({"quantity": "x", "unit": "m/s^2"} | options))


class Comma(float):
    def __format__(self, form):
        return super().__format__(form).replace(".", ",")


class Clock(float):
    """Times of day that pass midnight after 50 ms."""

    def __format__(self, form):
        late = self > 0.0499
        time = f"00:00:{self - 0.05:07.4f}" if late else f"23:59:{59.95 + self:.4f}"
        return f"2024-03-0{2 if late else 1}\t{time}"


def write(path, head, row, tail=(), number=float, encoding="utf-8"):
    values = ((*(number(x) for x in (t, 1e3 * t, 1e6 * t, a, b)), Clock(t))
              for t, a, b in zip(T, *Y, strict=True))  # fmt: skip
    rows = [
        row.format(i=i, **dict(zip("tmuabc", each, strict=True)))
        for i, each in enumerate(values, 1)
    ]
    path.write_text("\r\n".join([*head, *rows, *tail]), encoding=encoding, newline="")


PLAIN = "{t:.5f},{a:.5f},{b:.5f}"
LVM = ["LabVIEW Measurement", "Separator\tTab", "***End_of_Header***", "", "Channels\t2"]
LVM += ["Samples\t200\t200", "Y_Unit_Label\tg\tg", "Delta_X\t0.0005\t0.0005"]
LVM += ["***End_of_Header***", "X_Value\ta\tb\tComment"]
KEYS = ["Title: decay of a beam", "Date: 2024-03-01", "Channels: 2"]
DATES = ["File;hit 4", "Date;01.03.2024", "Time;12:30:00", "Range;10,00"]
MEAN = ["Maximum;1,5;1,7", "Mean;0,1;0,0"]
DIALECTS = {  # first lines, each row, last lines, unit; also with decimal commas
    "plain": (["time,a,b"], PLAIN, [], None),
    "preamble": ([*KEYS, "time;a;b"], "{t:.5f};{a:.5f};{b:.5f};", ["", "End of data"], None),
    "dates": ([*DATES, "t;a;b", ""], "{t:.5f};{a:.5f};{b:.5f}", MEAN, None),
    "excel": (["sep=;", "time (s);a (mm/s);b (mm/s)"], "{t:.5f};{a:.6e};{b:.6e}", [], "mm/s"),
    "comments": (["# by hand", "# time [s]\ta [g]\tb [g]"], "{t:.5f}\t{a:+.6E}\t{b:.5f}", [], "g"),
    "row of units": (["Time,a,b", "s,g,g"], PLAIN, [], "g"),
    "slash": (["time/s;a/mm;b/mm"], "{t:.5f};{a:.5f};{b:.5f}", [], "mm"),
    "picoscope": (["Time,a,b", "(ms),(V),(V)", ""], "{m:.5f},{a:.5f},{b:.5f}", [], "V"),
    "quoted": (['"time","a","b"'], '"{t:.5f}","{a:.5f}","{b:.5f}"', [], None),
    "labview": (LVM, "{t:.5f}\t{a:.5f}\t{b:.5f}\t", [], "g"),
    "microseconds": (["t [µs];a;b"], "{u:.0f};{a:.5f};{b:.5f};", [], None),
    "times of day": (["Date\tTime\ta\tb"], "{c}\t{a:.5f}\t{b:.5f}", [], None),
    "index": (["Index\tt [ms]\ta\tb"], "{i}\t{m:.3f}\t{a:.5f}\t{b:.5f}", [], None),
    "rate in kHz": (["Abtastrate: 2.0 kHz", "a;b"], "{a:.5f};{b:.5f}", [], None),
    "interval": (["Sample interval (ms)\t0.5", "a\tb"], "{a:.5f}\t{b:.5f}", [], None),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize(
    ("dialect", "comma"),
    [
        (name, comma)
        for name, (_, row, *_) in DIALECTS.items()
        for comma in (False, True)
        if not comma or "," not in row or '"' in row  # commas separate columns
    ],
)
def test_text_of_all_dialects_has_its_values(dialect, comma, encoding, tmp_path):
    head, row, tail, unit = DIALECTS[dialect]
    write(tmp_path / "hit.csv", head, row, tail, Comma if comma else float, encoding)
    found = read(tmp_path / "hit.csv", unit="m/s^2" if unit in (None, "V") else None)
    (record,) = found
    assert found.channels == ("a", "b")
    assert found.unit == (unit if unit not in (None, "V") else "m/s^2")
    assert record.sample_rate == pytest.approx(RATE, rel=1e-6)
    np.testing.assert_array_equal(record.signal, Y)
    notes = {"V": ["a is in m/s^2 as given; the file states V"] * 2}.get(unit, [])
    if dialect == "index":
        notes = ["its first column, Index, numbers the samples"]
    assert [note.replace("b is", "a is") for note in record.notes] == notes


def test_damage_of_text_is_named(tmp_path):
    path = tmp_path / "hit.csv"
    write(path, ["Samples,500", "time,a,b"], PLAIN, tail=["0.1000,0."])
    assert read(path).records[0].notes == (
        "its last line, 203, is incomplete and was left out",
        "it states 500 samples and has 200",
    )
    for tail in ("0.1,x,1", "time,a,b\r\n0.1,1,2"):
        write(path, ["time,a,b"], PLAIN, tail=[tail])
        with pytest.raises(rom.SlipmodeError, match="line 202 must have one number a column"):
            read(path)


@pytest.mark.parametrize("form", ["%.4f", "%.5g", "%.4e"])
def test_rounded_times_are_even_and_a_lost_sample_is_not(form, tmp_path):
    t = np.arange(4096) / 2048.0
    table, path = np.column_stack([t, np.cos(t)]), tmp_path / "hit.csv"
    np.savetxt(path, table, [form, "%.5f"], ",", header="time,a", comments="")
    (record,) = read(path)
    assert record.sample_rate == pytest.approx(2048.0, rel=1e-5) and record.notes == ()
    lost = np.delete(table, 2000, axis=0)
    np.savetxt(path, lost, [form, "%.5f"], ",", header="time,a", comments="")
    with pytest.raises(rom.SlipmodeError, match=r"time \d+ is .* s off an even grid of 2047"):
        read(path)
    assert read(path, sample_rate=2048.0).records[0].sample_rate == 2048.0


def test_files_of_one_blow_are_records_in_natural_order(tmp_path):
    for k in (9, 10):
        arrays = {"time": T[:, None], "acc": k * Y[0][:, None], "Fs": RATE}
        scipy.io.savemat(tmp_path / f"hit{k}.mat", arrays)
        np.savez(tmp_path / f"hit{k}.npz", time=T, acc=k * Y.T)
        write(tmp_path / f"hit{k}.csv", ["time,tip,root"], PLAIN)
    for ending, channels in (
        (".mat", ("acc",)),
        (".npz", ("channel 0", "channel 1")),
        (".csv", ("tip", "root")),
    ):
        found = read(str(tmp_path / f"hit*{ending}"))
        assert [record.name for record in found] == ["hit9", "hit10"]  # not hit10 first
        assert found.channels == channels and found[10].name == "hit10"
        size = 1.0 if ending == ".csv" else 10.0
        np.testing.assert_array_equal(found["hit10"].signal, size * Y[: len(channels)])
        one = read(tmp_path / f"hit9{ending}", channels=channels[-1:])
        assert one.channels == channels[-1:] and one.records[0].signal.shape == (1, 200)


ARRAYS = {  # arrays of a file, options: names of records, channels
    "numbered": ({"v_3": Y[0], "v_7": Y[1], "sample_rate": RATE, "note": "text"}, {},
                 ["v_3", "v_7"], ("channel 0",)),
    "rows": ({"hit": Y, "time": T}, {}, ["hit"], ("channel 0", "channel 1")),
    "signals": ({"time": T, "tip": Y[0], "root": Y[1]}, {}, ["hits"], ("tip", "root")),
    "of one name": ({"time": T, "acc1": Y[0], "acc2": Y[1]}, {}, ["acc1", "acc2"],
                    ("channel 0",)),
    "chosen": ({"time": T, "acc1": Y[0], "acc2": Y[1]}, {"channels": ["acc1", "acc2"]}, ["hits"],
               ("acc1", "acc2")),
}  # fmt: skip


@pytest.mark.parametrize("ending", [".npz", ".mat"])
@pytest.mark.parametrize("case", ARRAYS)
def test_arrays_of_a_file_are_records_or_channels(case, ending, tmp_path):
    arrays, options, records, channels = ARRAYS[case]
    path = tmp_path / f"hits{ending}"
    if ending == ".npz":
        np.savez(path, **arrays)
    else:
        scipy.io.savemat(path, arrays)
    found = read(path, **options)
    assert [record.name for record in found] == records
    assert found.channels == channels
    np.testing.assert_array_equal(np.concatenate([record.signal for record in found]), Y)
    assert all(record.sample_rate == pytest.approx(RATE) for record in found)


def universal(path, signals):
    """Write data sets given as (node, label, ID, time stamp, samples) without other names."""
    write_uff(path, [(node, VELOCITY, "g", y) for node, *_, y in signals], RATE)
    pyuff = pytest.importorskip("pyuff")
    sets = pyuff.UFF(str(path)).read_sets()
    path.unlink()
    for each, (_, label, name, stamp, _) in zip(sets, signals, strict=True):
        each |= {"ordinate_axis_lab": label, "id1": name, "id3": stamp, "rsp_dir": 0}
        pyuff.UFF(str(path)).write_sets(each, "add")


@pytest.mark.oracle
@pytest.mark.parametrize("by", ["node", "label", "id1"])
def test_sensors_of_one_blow_in_universal_files_are_channels(by, tmp_path):
    signals = []
    for stamp in ("01-Mar-24 12:00:00", "01-Mar-24 12:01:00"):
        for k in (0, 1):
            own = {"node": k + 1, "label": f"a{k}", "id1": f"s{k}"}
            node, label, name = (own[key] if key == by else 0 for key in own)
            signals.append((node, label or "NONE", name or "NONE", stamp, Y[k]))
    names = {"node": ("1:+0", "2:+0"), "label": ("a0", "a1"), "id1": ("s0", "s1")}[by]
    universal(tmp_path / "two.uff", signals)
    universal(tmp_path / "one.uff", signals[:2])
    for name, records in (("two", ["two_1", "two_2"]), ("one", ["one"])):
        found = rom.read_measurement(tmp_path / f"{name}.uff", quantity="x")
        assert [record.name for record in found] == records
        assert (found.channels, found.unit) == (names, "g")
        assert found.records[-1].sample_rate == pytest.approx(RATE)
        np.testing.assert_allclose(found.records[-1].signal, Y, atol=1e-5)
        noted = "have one node and direction" in " ".join(found.records[0].notes)
        assert noted == (by != "node")


@pytest.mark.oracle
def test_forces_in_universal_files_are_no_channels(tmp_path):
    hammer = (1, FORCE, "N", np.hanning(200))
    write_uff(tmp_path / "hit.uff", [hammer, (2, VELOCITY, "m/s", Y[0])], RATE)
    found = rom.read_measurement(tmp_path / "hit.uff", quantity="velocity")
    assert (found.channels, found.unit) == (("2:+3",), "m/s")
    np.testing.assert_allclose(found[1].signal[0], Y[0], atol=1e-5)


def test_a_truncated_data_set_has_a_note(tmp_path):
    path = tmp_path / "hit.uff"
    write_uff(path, [(1, VELOCITY, "g", Y[0])], RATE)
    lines = path.read_bytes().splitlines(True)
    path.write_bytes(b"".join(lines[:33]) + b"    -1\n")
    (record,) = rom.read_measurement(path, quantity="x")
    assert record.notes == (f"1:+3 states 200 samples and has {record.samples}",)
    path.write_bytes(b"".join(lines) + b"".join(lines[:33]))
    (record,) = rom.read_measurement(path, quantity="x")
    assert record.samples == 200
    assert record.notes == ("the file ends within a data set, which was left out",)
