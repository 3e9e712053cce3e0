"""info, doctor, recover and export: of sound recordings and of damaged ones."""

import json

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from recordings import COUNT, STEP, chunk_end, chunks, damaged, flip, rewritten, samples, write

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import doctor, info, load, read, recover


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return write(tmp_path_factory.mktemp("whole") / "run.mcap")


def total(path):
    with path.open("rb") as file:
        return make_reader(file).get_summary().statistics.message_count


# info


def test_info_tells_what_is_there(whole):
    found = info(whole)
    assert (found.title, found.scene_name, found.run) == ("Both modes", "two", {"model": "1f2e"})
    assert [(c.topic, c.count) for c in found.channels[:3]] == [
        ("/modes", COUNT),
        ("/contact/0", COUNT),
        ("/events", 1),
    ]
    assert found.channels[1].units == {"x": "m", "v": "m/s", "f": "N"}
    assert found.span == (0.0, (COUNT - 1) * STEP)
    assert found.chunks == len(chunks(whole)) > 3
    assert found.damage == ""
    assert "  /contact/0          20000  x [m], v [m/s], f [N]\n" in found.text()


# doctor


def test_a_sound_recording_has_no_complaints(whole, capsys):
    assert doctor(whole) == []
    assert main(["doctor", str(whole)]) == 0
    assert capsys.readouterr().out.startswith(f"{whole}: sound\nnext: ")


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.slow)])
def test_doctor_notices_a_flip_of_any_byte_and_the_others_answer_or_refuse(tmp_path, every):
    whole = write(tmp_path / "run.mcap", 100)
    size = whole.stat().st_size
    summary = chunk_end(chunks(whole)[-1])
    rng = np.random.default_rng(2)
    positions = [*range(8, 200), *rng.integers(60, size, 200), *rng.integers(summary, size, 100)]
    for position in positions[::every]:
        path = damaged(whole, tmp_path, flip(position))
        assert doctor(path), f"byte {position} of {size}"
        for function in (read, info, lambda path: recover(path, tmp_path / "out.mcap")):
            try:
                function(path)
            except SlipmodeError as error:
                assert str(path) in str(error)
                assert "\n" not in str(error)


def test_recordings_of_the_plain_writer_are_read_and_sound(tmp_path):
    path = rewritten(tmp_path / "plain.mcap")
    assert doctor(path) == []
    np.testing.assert_array_equal(load(path)["/modes"].values, np.ones((50, 6)))
    assert recover(path, tmp_path / "again.mcap").kept == 100
    assert doctor(tmp_path / "again.mcap") == []


def test_time_that_runs_backwards(tmp_path):
    path = rewritten(tmp_path / "back.mcap", lambda topic, number: 100 - number)
    assert doctor(path) == [f"{topic}: time runs backwards" for topic in ("/modes", "/contact/0")]


# recover


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(6))
def test_recovered_from_any_cut(whole, tmp_path, seed):
    first = chunks(whole)[0].chunk_start_offset
    cut = int(np.random.default_rng(seed).integers(first, whole.stat().st_size))
    path = damaged(whole, tmp_path, lambda data: data[:cut])
    before = path.read_bytes()
    out = tmp_path / "out.mcap"
    found = recover(path, out)
    assert path.read_bytes() == before
    assert doctor(out) == []
    assert read(out).complete
    with out.open("rb") as file:
        assert list(StreamReader(file, validate_crcs=True).records)
    for topic, signals in load(out).items():
        kept = signals.time.size
        np.testing.assert_array_equal(signals.values, samples()[topic][1][:kept])
    assert total(out) == found.kept + 1  # an event says what happened
    assert "recovered from a damaged recording" in read(out).events[-1].message
    assert f"its last {5000.0 - found.end:g} s are missing" in found.text()
    hit = [c for c in chunks(whole) if c.chunk_start_offset + 40 < cut < chunk_end(c)]
    in_each = total(whole) / len(chunks(whole))
    assert not hit or 0.5 * in_each < found.lost < 2 * in_each
    assert (found.lost > 0) == (found.lost_seconds > 0) == bool(hit)


def test_nothing_is_left_where_nothing_can_be_recovered(whole, tmp_path):
    path = damaged(whole, tmp_path, lambda data: data[:60])
    with pytest.raises(SlipmodeError, match=r"damaged\.mcap: ends before its first channel"):
        recover(path, tmp_path / "out.mcap")
    assert sorted(tmp_path.iterdir()) == [path]


# export


def exported(whole, out, *options):
    assert main(["export", str(whole), "-o", str(out), *options]) == 0
    return out


@pytest.mark.oracle
def test_npz(whole, tmp_path):
    with np.load(exported(whole, tmp_path / "run.npz", "--topics", "/modes", "/contact/0")) as a:
        assert json.loads(str(a["units"]))["/contact/0"]["v"] == "m/s"
        np.testing.assert_array_equal(a["/modes.time"], samples()["/modes"][0])
        np.testing.assert_array_equal(a["/contact/0.f"], samples()["/contact/0"][1][:, 2])


@pytest.mark.oracle
def test_csv(whole, tmp_path):
    exported(whole, tmp_path / "run.csv")
    assert (tmp_path / "run.modes.csv").is_file()
    table = pyarrow.csv.read_csv(tmp_path / "run.contact.0.csv")
    assert table.column_names == ["time [s]", "x [m]", "v [m/s]", "f [N]"]
    np.testing.assert_array_equal(table["v [m/s]"], samples()["/contact/0"][1][:, 1])


@pytest.mark.oracle
def test_parquet_of_one_channel(whole, tmp_path):
    table = pyarrow.parquet.read_table(
        exported(whole, tmp_path / "run.parquet", "--topics", "/contact/0")
    )
    assert table.schema.field("f").metadata == {b"unit": b"N"}
    np.testing.assert_array_equal(table["f"], samples()["/contact/0"][1][:, 2])
