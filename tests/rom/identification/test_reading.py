"""Files with measured records, and what is refused of them."""

import numpy as np
import pytest
import scipy.io
from measured.decays import RATE, decays, times
from measured.universal import FORCE, VELOCITY, write_uff

from slipmode import rom

SIGNALS = decays(1, 2, t=times(0.1))
GIVEN = {"quantity": "velocity", "unit": "m/s"}


def write_csv(path, columns, header=None, separator=","):
    lines = [separator.join(header)] if header else []
    lines += [separator.join(f"{x:.10g}" for x in row) for row in np.transpose(columns)]
    path.write_text("\n".join(lines) + "\n")


def test_csv_files_with_times_are_one_record_each(tmp_path):
    for k, y in zip((9, 10), SIGNALS, strict=True):
        write_csv(tmp_path / f"hit{k}.csv", [times(0.1), y, -y], ["time [s]", "tip", "root"])
    found = rom.read_measurement(str(tmp_path / "hit*.csv"), **GIVEN)
    assert [r.name for r in found] == ["hit9", "hit10"]  # not hit10 first
    assert found.channels == ("tip", "root")
    assert found[10].sample_rate == pytest.approx(RATE)
    assert found["hit9"].signal == pytest.approx(np.stack([SIGNALS[0], -SIGNALS[0]]), rel=1e-8)
    one = rom.read_measurement(tmp_path / "hit9.csv", channels=["root"], **GIVEN)
    assert one.channels == ("root",)
    assert one[9].signal.shape == (1, 200)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_csv_files_without_header_and_times(tmp_path, separator):
    write_csv(tmp_path / "a.csv", SIGNALS, separator=separator)
    found = rom.read_measurement(tmp_path / "a.csv", sample_rate=RATE, **GIVEN)
    assert found.channels == ("channel 0", "channel 1")
    assert found[1].signal == pytest.approx(np.stack(SIGNALS), rel=1e-8)


def test_a_first_column_of_times_needs_no_name(tmp_path):
    write_csv(tmp_path / "a.csv", [times(0.1), SIGNALS[0]])
    found = rom.read_measurement(tmp_path / "a.csv", **GIVEN)
    assert found.channels == ("channel 0",)
    assert found[1].sample_rate == pytest.approx(RATE)


def test_npz_and_mat_files_have_many_records(tmp_path):
    arrays = {"velocity_3": SIGNALS[0], "velocity_7": SIGNALS[1], "sample_rate": RATE}
    np.savez(tmp_path / "a.npz", **arrays, note="text is no record")
    scipy.io.savemat(tmp_path / "a.mat", arrays)
    for name in ("a.npz", "a.mat"):
        found = rom.read_measurement(tmp_path / name, **GIVEN)
        assert found.numbers == {3: "velocity_3", 7: "velocity_7"}
        assert found[7].signal[0] == pytest.approx(SIGNALS[1])
        assert found[7].sample_rate == RATE


def test_npz_files_with_channels(tmp_path):
    np.savez(tmp_path / "a.npz", hit=np.stack(SIGNALS), time=times(0.1))
    found = rom.read_measurement(tmp_path / "a.npz", channels=[1], **GIVEN)
    assert found["hit"].signal[0] == pytest.approx(SIGNALS[1])
    assert found["hit"].sample_rate == pytest.approx(RATE)


def write_hits(path, unit="m/s", nodes=(1, 2, 1)):
    signals = [(node, VELOCITY, unit, SIGNALS[k % 2]) for k, node in enumerate(nodes)]
    write_uff(path, signals, RATE)


def test_universal_files_state_rate_and_unit(tmp_path):
    write_hits(tmp_path / "hits.uff", nodes=(1, 2, 1, 2))
    found = rom.read_measurement(tmp_path / "hits.uff", quantity="velocity")
    assert found.unit == "m/s"
    assert found.channels == ("1:+3", "2:+3")
    assert [r.name for r in found] == ["hits_1", "hits_2"]
    assert found[1].sample_rate == pytest.approx(RATE)
    assert found[1].signal == pytest.approx(np.stack(SIGNALS), rel=1e-6)


def test_forces_in_universal_files_are_no_channels(tmp_path):
    hammer = (1, FORCE, "N", np.hanning(200))
    write_uff(tmp_path / "hit.uff", [hammer, (2, VELOCITY, "m/s", SIGNALS[0])], RATE)
    found = rom.read_measurement(tmp_path / "hit.uff", quantity="velocity")
    assert found.channels == ("2:+3",)
    assert found.unit == "m/s"


def refused(*arguments, **options):
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.read_measurement(*arguments, **(GIVEN | options))
    message = str(refusal.value)
    assert "\n" not in message
    return message


def test_a_missing_unit_or_rate_is_named(tmp_path):
    write_csv(tmp_path / "a.csv", SIGNALS)
    message = refused(tmp_path / "a.csv", unit=None, sample_rate=RATE)
    assert "give unit=, such as 'm/s'" in message
    assert "give sample_rate= [Hz]" in refused(tmp_path / "a.csv")
    assert "sample_rate = -1: must be > 0" in refused(tmp_path / "a.csv", sample_rate=-1)


def test_options_override_the_file_with_a_note(tmp_path):
    np.savez(tmp_path / "a.npz", hit=SIGNALS[0], fs=RATE)
    found = rom.read_measurement(tmp_path / "a.npz", sample_rate=1000.0, **GIVEN)
    assert found["hit"].sample_rate == 1000.0
    assert found["hit"].notes == ("the sampling rate is 1000 Hz as given; the file has 2000 Hz",)
    write_csv(tmp_path / "a.csv", [times(0.1), SIGNALS[0]], ["time [s]", "tip [V]"])
    found = rom.read_measurement(tmp_path / "a.csv", **GIVEN)
    assert found.unit == "m/s"
    assert found[1].notes == ("tip is in m/s as given; the file states V",)
    assert found[1].signal[0] == pytest.approx(SIGNALS[0], rel=1e-8)


def test_records_with_other_channels_are_refused(tmp_path):
    write_hits(tmp_path / "a.uff")  # of node 1 the second time without node 2
    assert "choose common ones by channels=" in refused(tmp_path / "a.uff")


def test_channels_that_do_not_exist_are_named(tmp_path):
    np.savez(tmp_path / "a.npz", hit=np.stack(SIGNALS), fs=RATE)
    message = refused(tmp_path / "a.npz", channels=["tip"])
    assert "has channel 0, channel 1, not 'tip'" in message
    assert "channels: " in refused(tmp_path / "a.npz", channels=[5])
    assert "each once" in refused(tmp_path / "a.npz", channels=[0, 0])


def test_unreadable_files_are_named(tmp_path):
    assert "there is no file" in refused(tmp_path / "none*.csv")
    broken = {
        "a.csv": "time,x\n0,1\n1,two\n",
        "b.csv": "",
        "c.npz": "no archive",
        "d.mat": "no matrix",
        "e.uff": "nothing",
        "f.wav": "RIFF",
    }
    for name, text in broken.items():
        (tmp_path / name).write_text(text)
        assert str(tmp_path / name) in refused(tmp_path / name, sample_rate=RATE)
    assert "line 3 must have one number a column" in refused(tmp_path / "a.csv")
    (tmp_path / "t.csv").write_text("time,x\n0.0,1\n1.0,2\n3.0,4\n")
    assert "times must rise in equal steps" in refused(tmp_path / "t.csv")


def test_records_of_one_name_are_refused(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        write_csv(tmp_path / folder / "hit.csv", SIGNALS)
    files = [tmp_path / folder / "hit.csv" for folder in ("a", "b")]
    assert "records hit occur more than once" in refused(files, sample_rate=RATE)
