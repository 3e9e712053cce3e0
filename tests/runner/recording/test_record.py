"""Recordings of runs, read by the packages of MCAP, Protobuf and Rerun."""

import subprocess

import numpy as np
import pytest
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import make_reader
from rrd import RERUN

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import doctor, load, shipped_scenes


def decoded(schema, data):
    pool = descriptor_pool.DescriptorPool()
    for file in FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(
        data
    )


@pytest.fixture(scope="module")
def run(shipped_scene):
    return shipped_scene("two-mode")


@pytest.fixture
def reader(run):
    with run.mcap.open("rb") as file:
        yield make_reader(file, validate_crcs=True)


@pytest.mark.oracle
@pytest.mark.parametrize("topic", ["/modes", "/forcing", "/contact/0", "/elastic", "/energy"])
def test_samples_decode_with_their_embedded_schema(run, reader, topic):
    signals = load(run.mcap)[topic]
    found = list(reader.iter_messages(topic))
    assert len(found) == len(signals.time) > 100
    chosen = np.linspace(0, len(found) - 1, 50).astype(int)
    for schema, _, message in (found[k] for k in chosen):
        sample = decoded(schema, message.data)
        (row,) = np.flatnonzero(np.rint(signals.time * 1e9) == message.log_time)
        assert [getattr(sample, name) for name in signals.units] == list(signals.values[row])
        assert message.log_time == message.publish_time


@pytest.mark.oracle
def test_units_metadata_statistics_and_scene(run, reader):
    metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    assert metadata["scene"]["name"] == "two-mode"
    assert all(metadata["run"].values())
    assert metadata["units"]["/modes.A_abs"] == "kg^0.5 m"
    assert metadata["units"]["/contact/0.f"] == "N"
    summary = reader.get_summary()
    by_topic = {channel.topic: channel for channel in summary.channels.values()}
    assert by_topic["/contact/0"].metadata["v"] == "m/s"
    (scene,) = reader.iter_attachments()
    assert (scene.name, scene.media_type) == ("scene.toml", "application/toml")
    assert scene.data == shipped_scenes()["two-mode"].read_bytes()
    assert summary.statistics.message_count == len(list(reader.iter_messages()))
    assert summary.statistics.message_end_time == 1_500_000_000_000
    assert all(index.uncompressed_size <= 2**20 for index in summary.chunk_indexes)
    assert {index.compression for index in summary.chunk_indexes} == {"zstd"}


@pytest.mark.oracle
def test_events_are_foxglove_logs(reader):
    schema, _, message = list(reader.iter_messages("/events"))[-1]
    assert schema.name == "foxglove.Log"
    log = decoded(schema, message.data)
    assert log.message == "end of the scene"
    assert log.DESCRIPTOR.enum_types_by_name["Level"].values_by_number[log.level].name == "INFO"
    assert log.timestamp.seconds == 1500


@pytest.mark.oracle
def test_rerun_plots_the_modes_of_the_bare_mcap_file(run, reader, tmp_path):
    schema, channel, message = next(reader.iter_messages("/overview/modes"))
    assert (schema.name, channel.message_encoding) == ("sensor_msgs/msg/JointState", "cdr")
    assert b"|A| [kg^0.5 m]" in message.data
    bare = tmp_path / "bare.rrd"
    subprocess.run(
        [RERUN, "mcap", "convert", run.mcap, "-o", bare], capture_output=True, check=True
    )
    show = [RERUN, "rrd", "print", "-vvv", "--entity", "/overview/modes/position", bare]
    curves = subprocess.run(show, capture_output=True, check=True).stdout.decode()
    assert "Scalars:scalars" in curves


def test_a_channel_that_is_not_there_is_refused_with_the_present_ones(run):
    channels = load(run.mcap)
    with pytest.raises(SlipmodeError) as refusal:
        channels["/mode"]
    assert str(refusal.value).startswith("/mode: no such channel; the recording has /modes, ")
    assert isinstance(refusal.value, KeyError)
    with pytest.raises(SlipmodeError, match="/modes has no field C_abs: A_re"):
        channels["/modes"].column("C_abs")


@pytest.mark.parametrize("there", [True, False])
def test_a_link_is_replaced_and_its_target_stays(tmp_path, there):
    target, path = tmp_path / "precious.txt", tmp_path / "one-mode.mcap"
    if there:
        target.write_text("precious")
    path.symlink_to(target)
    assert main(["run", "one-mode", "-o", str(tmp_path)]) == 0
    assert not path.is_symlink() and doctor(path) == []
    assert target.exists() == there
    assert not there or target.read_text() == "precious"
