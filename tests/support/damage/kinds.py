"""Kinds of damage to recordings, each with its construction, and an independent reader."""

from collections import defaultdict

from mcap.opcode import Opcode
from mcap.reader import NonSeekingReader, make_reader

MAGIC = 8  # bytes at both ends of a file
HEAD = 9  # bytes of a record before its content: opcode and length


def places(data):
    """First byte and end of each record of a sound file, by its opcode."""
    found, start = defaultdict(list), MAGIC
    while start < len(data) - MAGIC:
        end = start + HEAD + int.from_bytes(data[start + 1 : start + HEAD], "little")
        found[Opcode(data[start])].append((start, end))
        start = end
    return found


def bit(opcode, number, offset, mask=1):
    """Turn over bits of a byte, `offset` bytes after the start of a record (before its end)."""

    def change(data):
        start, end = places(data)[opcode][number]
        data[(start if offset >= 0 else end) + offset] ^= mask

    return change


def forged(opcode, number, offset, value):
    """Write eight bytes of a record anew."""

    def change(data):
        start = places(data)[opcode][number][0] + offset
        data[start : start + 8] = value.to_bytes(8, "little")

    return change


def zeroed(opcode, number, offset, size):
    """Overwrite bytes with zeros, as a file system does that lost a block."""

    def change(data):
        start = places(data)[opcode][number][0] + offset
        data[start : start + size] = bytes(len(data[start : start + size]))

    return change


def cut(opcode, number, offset):
    """End the file `offset` bytes after the start of a record."""
    return lambda data: data[: places(data)[opcode][number][0] + offset]


def inserted(opcode, number, offset, piece):
    """Put bytes into the file, `offset` bytes after the start of a record."""

    def change(data):
        start = places(data)[opcode][number][0] + offset
        return data[:start] + piece + data[start:]

    return change


def removed(opcode, number, offset, size):
    """Take bytes out of the file; those of the whole record if `size` is None."""

    def change(data):
        start, end = places(data)[opcode][number]
        return data[: start + offset] + data[end if size is None else start + offset + size :]

    return change


O = Opcode  # noqa: E741

# Damage to a recording in three chunks: its construction, and how many chunks it may cost.
CHUNKED = {
    "header: length of a string": (bit(O.HEADER, 0, HEAD), 0),
    "first metadata: length of its map": (bit(O.METADATA, 0, HEAD + 4 + 3, 8), 0),
    "metadata of the scene: no UTF-8": (bit(O.METADATA, 1, -1, 0x80), 0),
    "metadata: length, smaller": (bit(O.METADATA, 2, 1, 0x40), 0),
    "attachment: length of the record": (bit(O.ATTACHMENT, 0, 1, 4), 0),
    "schema: length of the record": (bit(O.SCHEMA, 0, 1, 2), 0),
    "schema: data": (bit(O.SCHEMA, 0, -8, 0x10), 0),
    "channel: topic": (bit(O.CHANNEL, 0, HEAD + 9), 0),
    "channel: unit": (bit(O.CHANNEL, 1, -1), 0),
    "chunk: length, larger": (bit(O.CHUNK, 1, 6), 1),
    "chunk: opcode": (bit(O.CHUNK, 1, 0, 0x08), 1),
    "chunk: first time": (bit(O.CHUNK, 1, HEAD + 2), 0),
    "chunk: unpacked size of 8 GB": (forged(O.CHUNK, 1, HEAD + 16, 1 << 33), 0),
    "chunk: compression": (bit(O.CHUNK, 1, HEAD + 32), 1),
    "chunk: compressed data": (bit(O.CHUNK, 1, 5000), 1),
    "message index: length": (bit(O.MESSAGE_INDEX, 1, 2), 0),
    "message index: missing": (removed(O.MESSAGE_INDEX, 1, 0, None), 0),
    "end of data: length": (bit(O.DATA_END, 0, 1), 0),
    "summary: statistics": (bit(O.STATISTICS, 0, HEAD), 0),
    "summary: place of a chunk": (bit(O.CHUNK_INDEX, 0, HEAD + 18), 0),
    "summary: offset": (bit(O.SUMMARY_OFFSET, 0, HEAD + 2), 0),
    "footer: forged place of the summary": (forged(O.FOOTER, 0, HEAD, (1 << 64) - 1), 0),
    "footer: no summary": (forged(O.FOOTER, 0, HEAD, 0), 0),
    "footer: check sum": (bit(O.FOOTER, 0, -1), 0),
    "without the last magic": (cut(O.FOOTER, 0, 29), 0),
    "cut in the summary": (cut(O.STATISTICS, 0, 30), 0),
    "cut in a message index": (cut(O.MESSAGE_INDEX, -1, 50), 0),
    "cut in the head of a chunk": (cut(O.CHUNK, -1, 5), 1),
    "zeros from the head of a chunk on": (zeroed(O.CHUNK, 1, 0, 4096), 1),
    "zeros over the first metadata and channels": (zeroed(O.HEADER, 0, 20, 1500), 0),
    "zeros across two chunks": (zeroed(O.CHUNK, 2, -100_000, 150_000), 2),
    "zeros at the end": (lambda data: data + bytes(5000), 0),
    "two recordings in one file": (lambda data: data + data, 0),
    "chunk missing": (removed(O.CHUNK, 1, 0, None), 1),
    "bytes missing in a chunk": (removed(O.CHUNK, 1, 3000, 100), 1),
    "bytes inserted between records": (inserted(O.CHUNK, 1, 0, bytes(range(7, 207))), 0),
}

# Damage to a recording without chunks: its construction, and how many messages it may cost.
UNCHUNKED = {
    "message: length, larger": (bit(O.MESSAGE, 70, 1, 0x80), 3),
    "message: length, beyond the file": (bit(O.MESSAGE, 70, 5), 2),
    "message: unknown opcode": (bit(O.MESSAGE, 70, 0, 0x80), 1),
    "channel of half of the messages": (bit(O.CHANNEL, 0, 1, 2), 1),
    "zeros over messages": (zeroed(O.MESSAGE, 50, 10, 1000), 20),
    "bytes inserted between messages": (inserted(O.MESSAGE, 70, 0, bytes(range(7, 207))), 1),
    "cut in a message": (cut(O.MESSAGE, -1, 40), 1),
}


def messages(path):
    """Log time and bytes of the messages of each topic, by the readers of the mcap package.

    Both readers must agree: the one that uses the index, and the one that reads all records.
    """
    found = []
    with path.open("rb") as file:
        for reader in (make_reader, NonSeekingReader):
            file.seek(0)
            by_topic = defaultdict(list)
            each = reader(file, validate_crcs=True).iter_messages(log_time_order=False)
            for _, channel, message in each:
                by_topic[channel.topic].append((message.log_time, message.data))
            found.append(by_topic)
    assert found[0] == found[1]
    return found[0]
