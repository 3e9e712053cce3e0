"""Recordings for tests: channels, samples, and damage done to files."""

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer

from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Header, McapSink

SCENE = 'title = "Both modes"\n[run]\nduration = 5000.0\n'
HEADER = Header("Both modes", SCENE, {"model": "1f2e"}, "two")
CHANNELS = [channels.modes(), channels.contact(0)]
COUNT = 20_000  # samples of each channel, in several chunks
STEP = 0.25  # [s]


def samples(count=COUNT):
    """Time and values by topic."""
    rng = np.random.default_rng(11)
    time = np.arange(count) * STEP
    return {c.topic: (time, rng.normal(size=(count, len(c.fields)))) for c in CHANNELS}


def write(path, count=COUNT, block=1000):
    """A recording whose channels take turns, as those of a run."""
    with McapSink(path, HEADER, CHANNELS) as sink:
        sink.event(0.0, "info", "started")
        for start in range(0, count, block):
            for topic, (time, values) in samples(count).items():
                part = slice(start, min(start + block, count))
                sink.write(topic, time[part], values[part])
    return path


def chunks(path):
    """Index entries of the chunks of a whole file."""
    with path.open("rb") as file:
        return make_reader(file).get_summary().chunk_indexes


def chunk_end(chunk):
    """Where a chunk ends, its message indexes not counted."""
    return chunk.chunk_start_offset + chunk.chunk_length


def damaged(whole, folder, change):
    """A copy of a file, with what `change` makes of its bytes."""
    data = bytearray(whole.read_bytes())
    path = folder / "damaged.mcap"
    path.write_bytes(change(data) or data)
    return path


def flip(position):
    """Bits of one byte turned over."""

    def change(data):
        data[position] ^= 0x5A

    return change


def rewritten(
    path,
    time_ns=lambda topic, number: number,
    *,
    describe=True,
    units=True,
    length=0,
    chunked=True,
    library="another program",
):
    """A recording made with the plain writer: channels of ours, as they are or with a fault."""
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=chunked)
        writer.start(library=library)
        for channel in CHANNELS:
            schema = channel.descriptor().SerializeToString() if describe else b"\xff\xff"
            schema_id = writer.register_schema(channel.message_type, "protobuf", schema)
            about = {field.name: field.unit for field in channel.fields}
            channel_id = writer.register_channel(channel.topic, "protobuf", schema_id, about)
            for number, message in enumerate(channel.encode(np.ones((50, len(about))))):
                stamp = time_ns(channel.topic, number)
                data = message.tobytes()
                writer.add_message(channel_id, stamp, data[: len(data) + length], stamp)
        if units:
            writer.add_metadata("units", {})
        writer.finish()
    return path


def table(path):
    """Columns of a curve's CSV file by their names."""
    with path.open() as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",").T, strict=True))
