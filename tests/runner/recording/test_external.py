"""Recordings of other programs, written with the plain package, in replay."""

import json
import subprocess
from datetime import UTC, datetime

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, timestamp_pb2
from mcap.writer import CompressionType, Writer
from recordings import rewritten
from rerun.chunk import RrdReader
from rrd import RERUN, verified

from slipmode.__main__ import main

COUNT = 50
WALL = 1_700_000_000 * 10**9


def json_message(number):
    message = {"angle": np.sin(0.1 * number), "pose": {"x": number, "on": True}, "name": "arm"}
    message |= {"gains": [1.0, 2.0], "picture": list(range(100))}
    return message | ({"late": 2.0 * number} if number >= 30 else {})


def protobuf_schema():
    """A message with a number, a clock, and a list of messages, its files in the wrong order."""
    types = descriptor_pb2.FieldDescriptorProto
    inner = descriptor_pb2.DescriptorProto(name="Joint")
    inner.field.add(name="torque", number=1, type=types.TYPE_FLOAT, label=1)
    outer = descriptor_pb2.DescriptorProto(name="Robot", nested_type=[inner])
    outer.field.add(name="speed", number=1, type=types.TYPE_DOUBLE, label=1)
    outer.field.add(
        name="joints", number=2, type=types.TYPE_MESSAGE, label=3, type_name=".plant.Robot.Joint"
    )
    outer.field.add(
        name="stamp",
        number=3,
        type=types.TYPE_MESSAGE,
        label=1,
        type_name=".google.protobuf.Timestamp",
    )
    file = descriptor_pb2.FileDescriptorProto(
        name="robot.proto", package="plant", syntax="proto3", message_type=[outer]
    )
    file.dependency.append("google/protobuf/timestamp.proto")
    clock = descriptor_pb2.FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(clock)
    return descriptor_pb2.FileDescriptorSet(file=[file, clock])


def protobuf_message(number):
    def double(value):
        return np.float64(value).tobytes()

    joint = b"\x0d" + np.float32(number / 4).tobytes()
    return b"\x09" + double(number) + b"\x12" + bytes([len(joint)]) + joint + b"\x1a\x02\x08\x07"


def written(path, begin=0, publish=0, compression=CompressionType.ZSTD, chunked=True):
    """JSON, protobuf and an encoding that nobody knows."""
    with path.open("wb") as file:
        writer = Writer(file, compression=compression, use_chunking=chunked, chunk_size=2000)
        writer.start()
        schema = writer.register_schema("Arm", "jsonschema", b'{"type": "object"}')
        arm = writer.register_channel("/contact/0", "json", schema, {"angle": "rad"})
        data = protobuf_schema().SerializeToString()
        schema = writer.register_schema("plant.Robot", "protobuf", data)
        robot = writer.register_channel("/plant robot", "protobuf", schema)
        schema = writer.register_schema("sensor_msgs/msg/Image", "ros2msg", b"uint8[] data")
        camera = writer.register_channel("/camera", "cdr", schema)
        for number in range(COUNT):
            stamp = begin + number * 10**8
            for channel, message in (
                (arm, json.dumps(json_message(number)).encode()),
                (robot, protobuf_message(number)),
                (camera, b"\0\1\0\0picture"),
            ):
                writer.add_message(channel, stamp, message, stamp + publish)
        writer.finish()
    return path


def curves(path):
    """Times [s] and values of the curves in an .rrd file by their entities."""
    found = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if name.endswith("Scalars:scalars") and not chunk.is_static:
                time = np.array(batch.column("time").cast("int64")) / 1e9
                found[str(chunk.entity_path)] = time, np.array(batch.column(name).to_pylist())
    return found


def replayed(path, folder):
    assert main(["replay", str(path), "--save", str(folder / "out.rrd")]) == 0
    assert verified(folder / "out.rrd")
    return curves(folder / "out.rrd")


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("compression", "chunked", "begin"),
    [
        (CompressionType.ZSTD, True, 0),
        (CompressionType.LZ4, True, 0),
        (CompressionType.NONE, False, WALL),
    ],
)
def test_numbers_of_json_and_protobuf_are_shown(tmp_path, capsys, compression, chunked, begin):
    path = written(tmp_path / "plant.mcap", begin, compression=compression, chunked=chunked)
    before = path.read_bytes()
    found = replayed(path, tmp_path)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{path}: not shown: {COUNT} of /camera (cdr sensor_msgs/msg/Image)")
    assert path.read_bytes() == before
    number = np.arange(COUNT)
    for entity, expected in {
        "/other/contact/0/angle": np.sin(0.1 * number),
        "/other/contact/0/pose.x": number,
        "/other/plant robot/speed": number,
        "/other/plant robot/joints[0].torque": number / 4,
        "/other/contact/0/late": 2.0 * number[30:],
    }.items():
        ((time, values),) = (v for k, v in found.items() if k.replace("\\", "") == entity)
        np.testing.assert_allclose(values.ravel(), expected)
        np.testing.assert_allclose(time, 0.1 * number[-len(expected) :])
    text = subprocess.run(
        [RERUN, "rrd", "print", "-vvv", tmp_path / "out.rrd"], capture_output=True, text=True
    )
    assert "angle [rad]" in text.stdout
    start = datetime.fromtimestamp(WALL / 1e9, UTC).isoformat()
    assert (f"t = 0 is {start}" in text.stdout) == (begin == WALL)


def clocks_of_channels(path):
    times = {"/modes": WALL, "/contact/0": 0}
    path = rewritten(path, lambda topic, number: times[topic] + number, units=False)
    return path, "mixed clocks: /modes has times from 1970, /contact/0 from the run's start"


def clocks_of_a_message(path):
    return written(path, publish=WALL), "has publish times from 1970, log times from the run's"


@pytest.mark.parametrize("prepare", [clocks_of_channels, clocks_of_a_message])
def test_nothing_to_show_is_said_in_one_line(tmp_path, capsys, prepare):
    path, complaint = prepare(tmp_path / "bad.mcap")
    before = path.read_bytes()
    assert main(["replay", str(path), "--save", str(tmp_path / "out.rrd")]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(path) in line
    assert complaint in line
    assert path.read_bytes() == before
    assert not (tmp_path / "out.rrd").exists()
