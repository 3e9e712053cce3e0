"""Recordings of other programs, written with the plain package, in replay."""

import hashlib
import json
import subprocess
from datetime import UTC, datetime

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, timestamp_pb2
from mcap.writer import CompressionType, Writer
from recordings import chunks, damaged, flip, rewritten, write
from rrd import RERUN, verified

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner.recording.external import as_curves, is_external, read_external
from slipmode.runner.recording.load import Selection

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


def test_numbers_of_json_and_protobuf_are_found(tmp_path):
    path = written(tmp_path / "plant.mcap")
    assert is_external(path)
    data = read_external(path)
    number = np.arange(COUNT)
    arm, robot = data.channels["/contact/0"], data.channels["/plant robot"]
    assert arm.channel.names == ("angle", "pose.x", "pose.on", "gains[0]", "gains[1]", "late")
    assert arm.units["angle"] == "rad"
    np.testing.assert_allclose(arm.time, 0.1 * number)
    np.testing.assert_array_equal(arm.column("angle"), np.sin(0.1 * number))
    np.testing.assert_array_equal(arm.column("pose.x"), number)
    assert robot.channel.names == ("speed", "joints[0].torque")
    np.testing.assert_array_equal(robot.column("joints[0].torque"), number / 4)
    late = as_curves(data.channels)["/other/contact/0/late"]
    np.testing.assert_allclose(late.time, 0.1 * number[30:])
    np.testing.assert_array_equal(late.values[:, 0], 2.0 * number[30:])
    assert data.left_out == (
        f"{COUNT} of /camera (cdr sensor_msgs/msg/Image): neither JSON nor protobuf",
    )


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
def test_however_the_file_is_packed(tmp_path, compression, chunked):
    plain = read_external(written(tmp_path / "plain.mcap"))
    path = written(tmp_path / "packed.mcap", compression=compression, chunked=chunked)
    packed = read_external(path)
    assert packed.damage == ""
    for topic, signals in plain.channels.items():
        np.testing.assert_array_equal(packed.channels[topic].time, signals.time)
        np.testing.assert_array_equal(packed.channels[topic].values, signals.values)


def test_wall_time_counts_from_the_first_message(tmp_path):
    data = read_external(written(tmp_path / "wall.mcap", WALL))
    assert data.channels["/plant robot"].time[[0, -1]].tolist() == [0.0, 0.1 * (COUNT - 1)]
    begin = datetime.fromtimestamp(WALL / 1e9, UTC).isoformat()
    assert data.events[0].message.endswith(f"t = 0 is {begin}")


def test_replay_shows_the_numbers_and_says_what_it_does_not(tmp_path, capsys):
    path, out = written(tmp_path / "plant.mcap"), tmp_path / "out.rrd"
    before = hashlib.sha256(path.read_bytes()).digest()
    assert main(["replay", str(path), "--save", str(out)]) == 0
    printed = capsys.readouterr()
    assert printed.out == f"{out}\nnext:  rerun {out}\n"
    (line,) = printed.err.splitlines()
    assert line.startswith(f"{path}: not shown: {COUNT} of /camera (cdr sensor_msgs/msg/Image)")
    assert verified(out)
    show = [RERUN, "rrd", "print", "-vvv", out]
    text = subprocess.run(show, capture_output=True, check=True, text=True).stdout
    for words in ("angle [rad]", "/other/plant\\ robot/joints\\[0\\].torque", "not shown"):
        assert words in text, words
    assert hashlib.sha256(path.read_bytes()).digest() == before


def test_a_part_of_an_external_recording(tmp_path):
    data = read_external(written(tmp_path / "plant.mcap"))
    part = Selection(["/plant robot"], start=1.0, end=2.0).of(data)
    assert part.channels["/plant robot"].column("speed").tolist() == list(range(10, 21))
    assert list(as_curves(part.channels)) == [
        "/other/plant robot/speed",
        "/other/plant robot/joints[0].torque",
    ]


@pytest.mark.parametrize("ours", [True, False])
def test_a_damaged_file_is_replayed_up_to_the_damage(tmp_path, capsys, ours):
    whole = (write if ours else written)(tmp_path / "whole.mcap")
    third = chunks(whole)[2].chunk_start_offset
    changes = (lambda data: data[: third + 100], flip(third + 80))
    for change, words in zip(changes, ("the file ends at byte", "chunk"), strict=True):
        path = damaged(whole, tmp_path, change)
        before = path.read_bytes()
        assert main(["replay", str(path), "--save", str(tmp_path / "out.rrd")]) == 0
        first, *others = capsys.readouterr().err.splitlines()
        assert first.startswith(f"{path}: ")
        assert words in first
        assert "; shown up to t = " in first
        assert float(first.split("shown up to t = ")[1].split(" s")[0]) > 0.0
        assert len(others) == (not ours)
        assert path.read_bytes() == before


def rubbish_messages(path):
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("Arm", "jsonschema", b"{}")
        arm = writer.register_channel("/arm", "json", schema)
        text = writer.register_channel("/text", "json", schema)
        schema = writer.register_schema("plant.Robot", "protobuf", b"\xff\xff\xff")
        robot = writer.register_channel("/robot", "protobuf", schema)
        for number in range(3):
            writer.add_message(arm, number, b"{'x': ", number)
            writer.add_message(text, number, b'{"name": "arm"}', number)
            writer.add_message(robot, number, protobuf_message(number), number)
        writer.finish()
    return path, (
        "has no numbers to show (3 of /arm (json Arm): not JSON; 3 of /text (json Arm): no "
        "numbers; "
        "3 of /robot (protobuf plant.Robot): their schema cannot be read"
    )


def nothing(path):
    with path.open("wb") as file:
        Writer(file).start()
    return path, "has no numbers to show (the file ends at byte"


def no_messages(path):
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    return path, "has no numbers to show (no messages at all"


def clocks_of_channels(path):
    times = {"/modes": WALL, "/contact/0": 0}
    path = rewritten(path, lambda topic, number: times[topic] + number, units=False)
    return path, "mixed clocks: /modes has times from 1970, /contact/0 from the run's start"


def clocks_of_a_message(path):
    return written(path, publish=WALL), "has publish times from 1970, log times from the run's"


@pytest.mark.parametrize(
    "prepare", [rubbish_messages, nothing, no_messages, clocks_of_channels, clocks_of_a_message]
)
def test_nothing_to_show_is_said_in_one_line(tmp_path, capsys, prepare):
    path, complaint = prepare(tmp_path / "bad.mcap")
    before = path.read_bytes()
    assert main(["replay", str(path), "--save", str(tmp_path / "out.rrd")]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(path) in line
    assert complaint in line
    assert path.read_bytes() == before
    assert not (tmp_path / "out.rrd").exists()


def test_bits_turned_over_never_end_in_a_traceback(tmp_path):
    whole = written(tmp_path / "whole.mcap")
    positions = np.random.default_rng(8).integers(8, whole.stat().st_size, 150)
    for position in positions:
        try:
            read_external(damaged(whole, tmp_path, flip(position)))
        except SlipmodeError as error:
            assert "\n" not in str(error)
