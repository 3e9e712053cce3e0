"""What recordings cost, beside other writers and readers: make bench-recordings.

Every ratio is of best times in one run; the two sides take turns.
"""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import foxglove
import numpy as np
import rerun as rr
from foxglove.mcap import MCAPWriteOptions
from google.protobuf import descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
from zstandard import ZstdCompressor, ZstdDecompressor

from slipmode.runner import load_scene, run
from slipmode.runner.recording.channels import Channel, Field
from slipmode.runner.recording.load import load
from slipmode.runner.recording.mcap_file.writer import ZSTD_LEVEL
from slipmode.runner.recording.record import Header, McapSink
from slipmode.runner.view.drawing import time_column
from slipmode.runner.view.replay import replay

_ROWS, _PLAIN_ROWS = 500_000, 25_000  # messages of our side and of the mcap package
_FIELDS = 12
_CHANNEL = Channel("/wide", tuple(Field(f"x_{k}", "m") for k in range(_FIELDS)), "")
_REPEATS = 7
_ROWS_PER_SEND = 8192


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        for line in measure(Path(folder)):
            print(line, flush=True)


def measure(folder: Path, repeats: int = _REPEATS) -> Iterator[str]:
    """Yield the lines of the report; each side of a ratio takes `repeats` turns."""
    signals = _Signals(folder)
    yield f"messages of {_FIELDS} doubles, smooth signals, best of {repeats}"
    write = _best(
        repeats,
        ours=(signals.write, _ROWS),
        plain=(signals.write_plain, _PLAIN_ROWS),
        encoded=(signals.write_encoded, _PLAIN_ROWS),
        foxglove=(signals.write_foxglove, _PLAIN_ROWS),
        zstd=(signals.compress, _ROWS),
    )
    yield f"write MCAP                {write['ours'] / 1e6:6.2f} M/s"
    yield _ratio("times the mcap package, messages encoded before", write, "plain")
    yield _ratio("times the mcap package with protobuf encoding", write, "encoded")
    yield _ratio("times foxglove-sdk, messages encoded before", write, "foxglove")
    yield _ratio("of the rate of zstd alone", write, "zstd")
    read = _best(repeats, ours=(signals.read, _ROWS), plain=(signals.read_plain, _PLAIN_ROWS))
    yield f"read MCAP                 {read['ours'] / 1e6:6.2f} M/s"
    yield _ratio("times the mcap package with protobuf decoding", read, "plain")
    convert = _best(repeats, ours=(signals.convert, _ROWS), bare=(signals.send, _ROWS))
    yield f"MCAP to .rrd              {convert['ours'] / 1e6:6.2f} M rows/s"
    yield _ratio("of the rate of bare send_columns", convert, "bare")
    two_mode = _best(repeats, ours=(_logged(folder, True), 1), bare=(_logged(folder, False), 1))
    yield f"run two-mode              {1e3 / two_mode['ours']:6.0f} ms"
    yield f"{two_mode['bare'] / two_mode['ours']:12.2f}  times the time without recordings"


def _ratio(words: str, rates: dict[str, float], other: str) -> str:
    return f"{rates['ours'] / rates[other]:12.2f}  {words} ({rates[other] / 1e6:.2f} M/s)"


def _best(repeats: int, **sides: tuple[Callable[[], object], int]) -> dict[str, float]:
    """Highest rate of each side [1/s]: a function, and its number of items."""
    rates = dict.fromkeys(sides, 0.0)
    for _ in range(repeats):
        for name, (function, count) in sides.items():
            started = time.perf_counter()
            function()
            rates[name] = max(rates[name], count / (time.perf_counter() - started))
    return rates


def _logged(folder: Path, recorded: bool) -> Callable[[], object]:
    scene = load_scene("two-mode")
    log = dataclasses.replace(scene.log, mcap=recorded, rerun=recorded)
    scene = dataclasses.replace(scene, log=log)
    return lambda: run(scene, folder)


class _Signals:
    """The same messages for every side."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._time = np.arange(_ROWS) * 0.01
        growth = 1.0 - np.exp(-self._time / 900.0)
        waves = [np.sin((1 + 0.1 * k) * self._time) for k in range(_FIELDS)]
        self._values = growth[:, np.newaxis] * np.column_stack(waves)
        self._time_ns = np.rint(1e9 * self._time).astype(np.int64)
        pool = descriptor_pool.DescriptorPool()
        for proto in _CHANNEL.descriptor().file:
            pool.Add(proto)
        message = pool.FindMessageTypeByName(_CHANNEL.message_type)
        self._message: type[Any] = message_factory.GetMessageClass(message)
        self.write()
        self.encode()
        self.write_plain()
        with self._path("ours").open("rb") as file:
            records = list(StreamReader(file, emit_chunks=True).records)
        chunks = (each.data for each in records if isinstance(each, Chunk))
        self._raw = [ZstdDecompressor().decompress(data, 1 << 24) for data in chunks]

    def write(self) -> None:
        path = self._path("ours")
        path.unlink(missing_ok=True)  # to replace a file costs a wait for the disk
        with McapSink(path, Header("", ""), [_CHANNEL]) as sink:
            sink.write(_CHANNEL.topic, self._time, self._values)

    def write_plain(self) -> None:
        path = self._path("plain")
        path.unlink(missing_ok=True)
        with path.open("wb") as file:
            writer = Writer(file)
            writer.start()
            schema = _CHANNEL.descriptor().SerializeToString()
            schema_id = writer.register_schema(_CHANNEL.message_type, "protobuf", schema)
            channel_id = writer.register_channel(_CHANNEL.topic, "protobuf", schema_id)
            for stamp, data in zip(self._time_ns.tolist(), self._encoded, strict=False):
                writer.add_message(channel_id, stamp, data, stamp)
            writer.finish()  # type: ignore[no-untyped-call]

    def write_foxglove(self) -> None:
        context = foxglove.Context()
        schema = foxglove.Schema(
            name=_CHANNEL.message_type,
            encoding="protobuf",
            data=_CHANNEL.descriptor().SerializeToString(),
        )
        channel = foxglove.Channel(
            _CHANNEL.topic, schema=schema, message_encoding="protobuf", context=context
        )
        path = self._path("foxglove")
        path.unlink(missing_ok=True)
        options = MCAPWriteOptions(compression_level=ZSTD_LEVEL, compression_threads=0)
        with foxglove.open_mcap(path, context=context, writer_options=options):
            for stamp, data in zip(self._time_ns.tolist(), self._encoded, strict=False):
                channel.log(data, log_time=stamp)

    def write_encoded(self) -> None:
        self.encode()
        self.write_plain()

    def compress(self) -> None:
        compressor = ZstdCompressor(level=ZSTD_LEVEL)
        for raw in self._raw:
            compressor.compress(raw)

    def read(self) -> None:
        load(self._path("ours"))

    def read_plain(self) -> None:
        names = _CHANNEL.names
        rows = []
        with self._path("plain").open("rb") as file:
            for _, _, message in make_reader(file).iter_messages():
                sample = self._message.FromString(message.data)
                rows.append([getattr(sample, name) for name in names])
        np.array(rows)

    def convert(self) -> None:
        replay(self._path("ours"), save=self._folder / "ours.rrd")

    def send(self) -> None:
        stream = rr.RecordingStream("bare")
        stream.save(self._folder / "bare.rrd")
        for start in range(0, _ROWS, _ROWS_PER_SEND):
            part = slice(start, start + _ROWS_PER_SEND)
            columns = rr.Scalars.columns(scalars=self._values[part])
            stream.send_columns("/wide", [time_column(self._time_ns[part])], columns)
        stream.flush()
        stream.disconnect()

    def encode(self) -> None:
        rows = self._values[:_PLAIN_ROWS].tolist()
        fields = [dict(zip(_CHANNEL.names, row, strict=True)) for row in rows]
        self._encoded = [self._message(**values).SerializeToString() for values in fields]

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}.mcap"


if __name__ == "__main__":
    main()
