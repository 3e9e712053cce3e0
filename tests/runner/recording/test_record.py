"""Recordings are read back here with other readers than our own."""

import resource
import shutil
import subprocess
import sysconfig
from collections import namedtuple
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from slipmode import runner
from slipmode.rom import SlipmodeError
from slipmode.runner import load, read
from slipmode.runner.recording import channels, mcap_writer
from slipmode.runner.recording.overview import Overview
from slipmode.runner.recording.record import Header, McapSink, Recorder, Sink
from slipmode.runner.view import phase_portraits as portraits
from slipmode.runner.view.rerun_sink import RerunSink
from slipmode.runner.view.samples import Latest, Thinned

HEADER = Header("Both modes", 'title = "Both modes"\n', {"model": "1f2e", "started": "now"}, "two")
WIDE = channels.elastic(range(40))
CHANNELS = [channels.modes(), channels.contact(0), channels.contact(1), WIDE]
RERUN = shutil.which("rerun", path=sysconfig.get_path("scripts"))


def batches(n=300):
    rng = np.random.default_rng(7)
    time = np.arange(n) * 0.1
    return {
        channel.topic: (time, rng.normal(size=(n, len(channel.fields)))) for channel in CHANNELS
    }


def fill(sink, n=300):
    for topic, (time, values) in batches(n).items():
        sink.write(topic, time, values)
    sink.event(12.5, "warning", "amplitude near the edge of the table")


@contextmanager
def largest_file(size):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def decoded(schema, data):
    pool = descriptor_pool.DescriptorPool()
    for file in FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(
        data
    )


@pytest.fixture
def recorded(tmp_path):
    path = tmp_path / "run.mcap"
    with McapSink(path, HEADER, CHANNELS) as sink:
        fill(sink)
    with path.open("rb") as file:
        yield make_reader(file, validate_crcs=True)


@pytest.mark.parametrize("channel", CHANNELS, ids=lambda channel: channel.topic)
def test_samples_decode_with_their_embedded_schema(recorded, channel):
    time, values = batches()[channel.topic]
    found = list(recorded.iter_messages(channel.topic))
    assert len(found) == len(time)
    for (schema, _, message), seconds, row in zip(found, time, values, strict=True):
        sample = decoded(schema, message.data)
        assert [getattr(sample, name) for name in channel.names] == list(row)
        assert message.log_time == message.publish_time == round(seconds * 1e9)


def test_units_metadata_and_scene(recorded):
    metadata = {record.name: record.metadata for record in recorded.iter_metadata()}
    assert metadata["run"] == HEADER.run
    assert metadata["scene"] == {"title": "Both modes", "name": "two"}
    assert metadata["units"]["/modes.A_abs"] == "kg^0.5 m"
    assert metadata["units"]["/contact/1.f"] == "N"
    assert len(metadata["units"]) == sum(len(channel.fields) for channel in CHANNELS)
    by_topic = {channel.topic: channel for channel in recorded.get_summary().channels.values()}
    assert by_topic["/contact/0"].metadata["v"] == "m/s"
    (scene,) = recorded.iter_attachments()
    assert (scene.name, scene.media_type) == ("scene.toml", "application/toml")
    assert scene.data.decode() == HEADER.scene_text


def test_a_channel_that_is_not_there_is_refused_with_those_that_are(tmp_path):
    with McapSink(tmp_path / "run.mcap", HEADER, CHANNELS) as sink:
        fill(sink, 5)
    channels = load(tmp_path / "run.mcap")
    with pytest.raises(SlipmodeError) as refusal:
        channels["/mode"]
    topics = ", ".join(channel.topic for channel in CHANNELS)
    assert str(refusal.value) == f"/mode: no such channel; the recording has {topics}"
    assert isinstance(refusal.value, KeyError)
    assert channels.get("/mode") is None and "/mode" not in channels


@pytest.mark.parametrize("call", [runner.run, runner.load_scene])
def test_what_is_no_scene_is_refused(call):
    with pytest.raises(SlipmodeError, match=r"^scene: must be a string or a path, got 3$"):
        call(3)


def test_what_is_no_file_is_refused():
    with pytest.raises(SlipmodeError, match=r"^path: must be a string or a path, got 3$"):
        load(3)


def test_statistics_and_chunks(tmp_path):
    path = tmp_path / "run.mcap"
    with McapSink(path, HEADER, CHANNELS) as sink:
        fill(sink, 5000)
    with path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    overview = 4096 + (5000 - 4096) // 2  # it gets thinner
    assert summary.statistics.message_count == 4 * 5000 + 1 + overview
    assert summary.statistics.message_start_time == 0
    assert summary.statistics.message_end_time == 499_900_000_000
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 1
    assert all(index.uncompressed_size <= 2**20 for index in summary.chunk_indexes)
    assert {index.compression for index in summary.chunk_indexes} == {"zstd"}


def test_the_same_bytes_however_slowly_they_are_written(tmp_path, monkeypatch):
    paths = [tmp_path / name for name in ("fast.mcap", "slow.mcap")]
    for path, seconds in zip(paths, (1e9, 0.0), strict=True):
        monkeypatch.setattr(mcap_writer, "FLUSH_SECONDS", seconds)
        with McapSink(path, HEADER, CHANNELS) as sink:
            for start in range(0, 8000, 1000):
                for topic, (time, values) in batches(8000).items():
                    part = slice(start, start + 1000)
                    sink.write(topic, time[part], values[part])
    fast, slow = (path.read_bytes() for path in paths)
    assert fast == slow


def test_samples_are_in_the_file_before_their_chunk_is_full(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_writer, "FIRST_FLUSH_SECONDS", 0.0)
    path = tmp_path / "run.mcap"
    sink = McapSink(path, HEADER, CHANNELS)
    for count in (200, 500, 20_000):  # more than a chunk last
        sink.write("/modes", *batches(count)["/modes"])
        data = read(path)
        assert not data.complete
        np.testing.assert_array_equal(
            data.channels["/modes"][2][-1], batches(count)["/modes"][1][-1]
        )
    sink.close()
    assert read(path).complete
    with path.open("rb") as file:
        assert list(StreamReader(file, validate_crcs=True).records)


def test_modes_are_also_there_in_a_form_that_viewers_plot_by_themselves(recorded, tmp_path):
    time, values = batches()["/modes"]
    ((schema, channel, message), *others) = recorded.iter_messages("/overview/modes")
    assert (schema.name, channel.message_encoding) == ("sensor_msgs/msg/JointState", "cdr")
    assert len(others) == len(time) - 1
    assert b"|A| [kg^0.5 m]" in message.data
    assert b"|B| [kg^0.5 m]" in message.data
    bare, curve = tmp_path / "bare.rrd", "/overview/modes/position"
    convert = [RERUN, "mcap", "convert", recorded._stream.name, "-o", bare]
    subprocess.run(convert, capture_output=True, check=True)
    show = [RERUN, "rrd", "print", "-vvv", "--entity", curve, bare]
    curves = subprocess.run(show, capture_output=True, check=True).stdout.decode()
    assert "Scalars:scalars" in curves
    assert f"[{values[0, 4]}, {values[0, 5]}]" in curves


def test_the_overview_gets_thinner_as_the_run_gets_longer():
    found = []
    overview = Overview(channels.modes())
    for start in range(0, 100_000, 999):
        number = np.arange(start, min(start + 999, 100_000))
        times, messages = overview.encode(number, np.repeat(number[:, np.newaxis], 6, axis=1))
        np.testing.assert_array_equal(messages["position"][:, 1], times)
        found += times.tolist()
    steps = np.diff(found)
    assert found[0] == 0
    assert set(steps) == {1, 2, 4, 8, 16, 32}
    assert np.all(np.diff(steps) >= 0)
    assert np.all(steps[1:] <= np.maximum(1, np.array(found[1:-1]) / 2048))


def test_messages_longer_than_a_chunk(tmp_path):
    path = tmp_path / "run.mcap"
    text = "a long story " * 100_000
    with McapSink(path, HEADER, CHANNELS) as sink:
        fill(sink, 10)
        sink.event(1.0, "info", text)
        fill(sink, 10)
    assert [event.message for event in read(path).events][1] == text


def test_events_are_foxglove_logs(recorded):
    ((schema, _, message),) = recorded.iter_messages("/events")
    assert schema.name == "foxglove.Log"
    log = decoded(schema, message.data)
    assert log.message == "amplitude near the edge of the table"
    assert log.DESCRIPTOR.enum_types_by_name["Level"].values_by_number[log.level].name == "WARNING"
    assert (log.timestamp.seconds, log.timestamp.nanos) == (12, 500_000_000)


def test_a_mode_that_is_not_modelled_has_no_fields():
    assert channels.modes(("A",)).names == ("A_re", "A_im", "A_abs")
    assert channels.forcing(("B",)).names == ("B_force", "B_frequency", "B_phase")


def test_samples_that_tools_have_encoded_otherwise_are_refused():
    contact = channels.contact(0)
    with pytest.raises(SlipmodeError, match="/contact/0"):
        contact.decode(np.array([b"\x09" + bytes(8)], np.void))
    with pytest.raises(SlipmodeError, match="/contact/0"):
        contact.decode(np.array([bytes(27)], np.void))


@pytest.mark.parametrize("kind", [McapSink, RerunSink])
@pytest.mark.parametrize(
    ("topic", "time", "values", "complaint"),
    [
        (
            "/contact/0",
            [0.0, 0.5],
            [[0, 0, 0], [0, np.nan, 0]],
            "/contact/0: v must be finite, got nan at t = 0.5",
        ),
        ("/contact/0", [0.0], [[0, 0, np.inf]], "/contact/0: f must be finite, got inf"),
        ("/contact/0", [0.0], [[0, 0]], r"shape \(1, 3\), got \(1, 2\)"),
        ("/contact/0", [-1.0], [[0, 0, 0]], "times must be finite and not negative"),
        ("/contact/0", [np.nan], [[0, 0, 0]], "times must be finite and not negative"),
        ("/contact/7", [0.0], [[0, 0, 0]], "/contact/7: is not recorded"),
    ],
)
def test_bad_samples_are_refused(tmp_path, kind, topic, time, values, complaint):
    with kind(tmp_path / "run", HEADER, CHANNELS) as sink, pytest.raises(SlipmodeError) as refusal:
        sink.write(topic, time, values)
    refusal.match(complaint)


@pytest.mark.parametrize("kind", [McapSink, RerunSink])
def test_paths_that_cannot_be_written(tmp_path, kind):
    with pytest.raises(SlipmodeError, match="is a directory"):
        kind(tmp_path, HEADER, CHANNELS)
    missing = tmp_path / "missing" / "run"
    with pytest.raises(FileNotFoundError, match=str(missing)):
        kind(missing, HEADER, CHANNELS)
    with pytest.raises(OSError, match="/dev/full"):
        kind("/dev/full", HEADER, CHANNELS)


@pytest.mark.parametrize("kind", [McapSink, RerunSink])
@pytest.mark.parametrize("there", [True, False])
def test_a_link_is_replaced_and_its_target_stays(tmp_path, kind, there):
    target, path = tmp_path / "precious.txt", tmp_path / "run"
    if there:
        target.write_text("precious")
    path.symlink_to(target)
    with kind(path, HEADER, CHANNELS) as sink:
        fill(sink, 5)
    assert not path.is_symlink() and path.stat().st_size > 100
    assert target.exists() == there
    assert not there or target.read_text() == "precious"


def test_another_name_of_a_recording_keeps_the_recording(tmp_path):
    path, other = tmp_path / "run.mcap", tmp_path / "other.mcap"
    for count in (10, 20):
        with McapSink(path, HEADER, CHANNELS) as sink:
            fill(sink, count)
        if not other.exists():
            other.hardlink_to(path)
    assert load(other)["/modes"].time.size == 10
    assert load(path)["/modes"].time.size == 20


def test_full_disk_keeps_what_was_written(tmp_path):
    path = tmp_path / "run.mcap"
    sink = McapSink(path, HEADER, CHANNELS)
    with largest_file(1_500_000), pytest.raises(OSError, match=str(path)):
        fill(sink, 20000)
    sink.close()
    assert path.stat().st_size == 1_500_000
    data = read(path)
    assert not data.complete
    kept = data.channels["/modes"][2]
    assert len(kept) > 5000
    np.testing.assert_array_equal(kept, batches(20000)["/modes"][1][: len(kept)])


def test_closing_does_not_hide_the_first_error(tmp_path):
    sink = McapSink(tmp_path / "run.mcap", HEADER, CHANNELS[:1])
    sink.write("/modes", *batches(100)["/modes"])
    with pytest.raises(KeyError, match="solver"), largest_file(2000), sink:
        raise KeyError("solver")


def test_rerun_stops_before_the_disk_is_full(tmp_path, monkeypatch):
    path = tmp_path / "run.rrd"
    usage = namedtuple("usage", "total used free")
    with RerunSink(path, HEADER, CHANNELS) as sink:
        fill(sink)
        monkeypatch.setattr(shutil, "disk_usage", lambda folder: usage(10**9, 10**9, 1000))
        with pytest.raises(OSError, match="No space left on device") as failure:
            fill(sink)
    assert failure.value.filename == str(path)
    assert verified(path)


class FailingSink(Sink):
    def write(self, topic, time, values):
        pass

    def event(self, time, level, message):
        pass

    def close(self):
        raise OSError("cannot close")


def test_recorder_closes_every_sink_when_one_fails(tmp_path):
    paths = [tmp_path / "first.mcap", tmp_path / "last.mcap"]
    first, last = (McapSink(path, HEADER, CHANNELS) for path in paths)
    recorder = Recorder([first, FailingSink(), last])
    fill(recorder)
    with pytest.raises(OSError, match="cannot close"):
        recorder.close()
    assert all(read(path).complete for path in paths)


def test_rerun_file_holds_legends_with_units_and_scales(tmp_path):
    path = tmp_path / "run.rrd"
    with RerunSink(path, HEADER, CHANNELS) as sink:
        sink.write("/modes", [0.0, 1.0], np.ones((2, 6)))
        sink.write("/contact/0", [0.0, 1.0], [[0.15, 0.0, -2.0], [-0.1, 0.0, 1.0]])
    assert verified(path)
    text = subprocess.run([RERUN, "rrd", "print", "-vvv", path], capture_output=True, check=True)
    assert b"|A| [kg^0.5 m]" in text.stdout
    for label in ("x: ±0.15 m".encode(), "f: ±2 N".encode()):
        assert label in text.stdout
    assert HEADER.title.encode() in text.stdout


def test_views_exist_only_for_what_is_recorded():
    one = [channels.modes(("A",)), channels.contact(0)]
    assert [portrait.entity for portrait in portraits.portraits(one)] == [
        "/phase_plane/A",
        "/loop/contact/0",
    ]
    many = [channels.contact(number) for number in range(6)]
    drawn = [portrait.entity for portrait in portraits.portraits(many)]
    assert drawn == ["/trajectory", *(f"/loop/contact/{number}" for number in range(3))]


def test_of_long_motion_the_latest_is_drawn():
    samples = Latest()
    for start in range(0, 200_000, 777):
        samples.extend(np.arange(start, min(start + 777, 200_000))[:, np.newaxis])
    np.testing.assert_array_equal(samples.rows()[:, 0], np.arange(200_000)[-8192:])


def test_long_paths_are_thinned_evenly():
    samples = Thinned()
    for start in range(0, 200_000, 777):
        samples.extend(np.arange(start, min(start + 777, 200_000))[:, np.newaxis])
    (kept,) = samples.rows().T
    assert 4096 <= len(kept) <= 8192
    assert kept[0] == 0
    assert set(np.diff(kept)) == {32}


def verified(path: Path) -> bool:
    done = subprocess.run([RERUN, "rrd", "verify", path], capture_output=True, text=True)
    return done.returncode == 0 and "verified without error" in done.stdout + done.stderr
