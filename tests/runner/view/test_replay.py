"""Reading recordings back, whole and damaged, and showing them."""

import struct
import subprocess

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from rrd import RERUN, verified

from slipmode.rom import SlipmodeError
from slipmode.runner import read, replay
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Header, McapSink
from slipmode.runner.view.rerun_sink import RerunSink

HEADER = Header("Both modes", 'title = "Both modes"\n', {"model": "1f2e"}, "two")
CHANNELS = [channels.modes(), channels.forcing(), channels.contact(0), channels.contact(1)]
OVERVIEW = len(CHANNELS) + 2  # number of the channel that is thinned and not read back


def batches(n=400):
    rng = np.random.default_rng(3)
    time = np.arange(n) * 0.25
    return {
        channel.topic: (time, rng.normal(size=(n, len(channel.fields)))) for channel in CHANNELS
    }


def fill(sink, n=400):
    for topic, (time, values) in batches(n).items():
        sink.write(topic, time, values)
    sink.event(0.0, "info", "started")
    sink.event(99.75, "error", "stopped")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "run.mcap"
    with McapSink(path, HEADER, CHANNELS) as sink:
        fill(sink)
    return path


@pytest.fixture(scope="module")
def long_recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "long.mcap"
    with McapSink(path, HEADER, CHANNELS) as sink:
        fill(sink, 12000)
    return path


def test_what_was_written_is_read(recording):
    data = read(recording)
    assert data.damage == ""
    assert not data.complete  # the run was stopped
    assert data.header == HEADER
    assert data.scene_text == HEADER.scene_text
    assert [channel for channel, _, _ in data.channels.values()] == CHANNELS
    for topic, (time, values) in batches().items():
        np.testing.assert_array_equal(data.channels[topic][1], time)
        np.testing.assert_array_equal(data.channels[topic][2], values)
    assert data.events == [
        channels.Event(0.0, "info", "started"),
        channels.Event(99.75, "error", "stopped"),
    ]


def test_a_recording_without_samples(tmp_path):
    path = tmp_path / "empty.mcap"
    McapSink(path, HEADER, CHANNELS).close()
    data = read(path)
    assert data.complete
    assert [values.shape for _, _, values in data.channels.values()] == [
        (0, 6),
        (0, 6),
        (0, 3),
        (0, 3),
    ]
    replay(path, save=tmp_path / "empty.rrd")
    assert verified(tmp_path / "empty.rrd")


def test_every_whole_chunk_of_a_truncated_file_is_read(long_recording, tmp_path):
    whole = long_recording.read_bytes()
    with long_recording.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert len(chunks) > 2
    ends = [chunk.chunk_start_offset + chunk.chunk_length for chunk in chunks]
    rng = np.random.default_rng(5)
    cuts = {*rng.integers(0, len(whole), 25).tolist(), *ends, *(end - 1 for end in ends)}
    cut_file = tmp_path / "cut.mcap"
    for cut in sorted(cuts):
        cut_file.write_bytes(whole[:cut])
        survivors = [end for end in ends if end <= cut]
        data = read(cut_file)
        assert not data.complete
        assert data.events[-1].level == "warning"
        assert samples_in(data) == messages_in(whole, chunks[: len(survivors)])


def test_a_file_cut_at_any_early_byte_gives_a_recording_or_one_clear_line(recording, tmp_path):
    whole = recording.read_bytes()
    with recording.open("rb") as file:
        (chunk,) = make_reader(file).get_summary().chunk_indexes
    cut_file = tmp_path / "cut.mcap"
    refused = 0
    for cut in range(chunk.chunk_start_offset + 100):
        cut_file.write_bytes(whole[:cut])
        try:
            data = read(cut_file)
        except SlipmodeError as error:
            refused += 1
            assert "\n" not in str(error)
            assert str(cut_file) in str(error)
        else:
            assert not data.complete
    assert 0 < refused < chunk.chunk_start_offset


def test_damage_within_a_chunk_is_noticed(long_recording, tmp_path):
    damaged = bytearray(long_recording.read_bytes())
    with long_recording.open("rb") as file:
        second = make_reader(file).get_summary().chunk_indexes[1]
    damaged[second.chunk_start_offset + second.chunk_length // 2] ^= 0x10
    path = tmp_path / "damaged.mcap"
    path.write_bytes(damaged)
    data = read(path)
    assert not data.complete
    assert samples_in(data) > 0
    _, values = batches(12000)["/modes"]
    kept = data.channels["/modes"][2]
    np.testing.assert_array_equal(kept, values[: len(kept)])
    assert "cut short" in data.events[-1].message


def test_files_that_are_no_recordings(tmp_path):
    empty, text, external = (tmp_path / name for name in ("empty.mcap", "text.mcap", "other.mcap"))
    empty.touch()
    text.write_text("not a recording at all")
    with external.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    complaints = {
        tmp_path: "Is a directory",
        tmp_path / "missing.mcap": "No such file",
        empty: "an empty file",
        text: "not an MCAP file",
        external: ": not a recording of slipmode",
    }
    for path, complaint in complaints.items():
        with pytest.raises(SlipmodeError, match=complaint) as refusal:
            read(path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_replay_shows_what_the_run_would_have_shown(recording, tmp_path):
    with RerunSink(tmp_path / "run.rrd", HEADER, CHANNELS) as sink:
        fill(sink)
    replay(recording, save=tmp_path / "replay.rrd")
    assert verified(tmp_path / "replay.rrd")
    compared = subprocess.run(
        [RERUN, "rrd", "compare", "--unordered", tmp_path / "run.rrd", tmp_path / "replay.rrd"],
        capture_output=True,
        text=True,
    )
    assert compared.returncode == 0, compared.stderr[-500:]


def test_replay_of_a_truncated_recording(recording, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[:-100])
    replay(cut, save=tmp_path / "cut.rrd")
    assert verified(tmp_path / "cut.rrd")
    text = subprocess.run(
        [RERUN, "rrd", "print", "-vvv", tmp_path / "cut.rrd"], capture_output=True, check=True
    )
    assert b"cut short" in text.stdout


def test_screenshot_without_a_renderer_names_the_packages(recording, tmp_path, monkeypatch):
    monkeypatch.setenv("VK_ICD_FILENAMES", str(tmp_path / "none.json"))
    monkeypatch.setenv("VK_DRIVER_FILES", str(tmp_path / "none.json"))
    monkeypatch.setenv("LIBGL_DRIVERS_PATH", str(tmp_path))
    with pytest.raises(SlipmodeError, match=r"apt-get install .*mesa-vulkan-drivers"):
        replay(recording, screenshot=tmp_path / "views.png")
    assert not (tmp_path / "views.png").exists()


def samples_in(data):
    recorded = sum(len(time) for _, time, _ in data.channels.values())
    return recorded + len(data.events) - bool(data.damage)  # the warning is ours


def messages_in(whole, chunks):
    """Messages of some chunks, by their indexes: 16 bytes for each of them."""
    count = 0
    for chunk in chunks:
        for channel, offset in chunk.message_index_offsets.items():
            if channel == OVERVIEW:
                continue
            (size,) = struct.unpack_from("<I", whole, offset + 1 + 8 + 2)
            count += size // 16
    return count
