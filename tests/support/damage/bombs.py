"""Small recordings that unpack to much more than their size, written by the records of `mcap`."""

import struct

import lz4.frame
import zstandard
from damage.kinds import inserted
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk

MIB = 1024 * 1024
ALLOWED = 48 * MIB  # bytes that a chunk of a small file may have: a little less than 256 MiB / 5


def endless_zstd(size, stated=True):
    """A zstd frame of zeros: blocks of 128 KiB, each a byte to repeat (RFC 8878, 3.1.1)."""
    window = b"" if stated else b"\x38"  # 128 KiB
    head = (b"\xe0" + size.to_bytes(8, "little")) if stated else b"\x00" + window
    blocks = size // (MIB // 8)
    block = (MIB // 8 << 3) | 2
    body = (block.to_bytes(3, "little") + b"\0") * (blocks - 1)
    return b"\x28\xb5\x2f\xfd" + head + body + (block | 1).to_bytes(3, "little") + b"\0"


def endless_lz4(size):
    """An lz4 frame of zeros of no stated size: the same block of 4 MiB again and again."""
    options = {"block_size": lz4.frame.BLOCKSIZE_MAX4MB, "block_linked": False}
    one = lz4.frame.compress(bytes(4 * MIB), store_size=False, **options)
    return one[:7] + one[7:-4] * (size // (4 * MIB)) + bytes(4)


def chunk(data, size, compression="zstd"):
    """A chunk record that claims to unpack to `size` bytes, without a check sum."""
    return written(Chunk(compression, data, 0, 0, 0, size))


def written(record):
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def packed(piece, size=ALLOWED):
    """A chunk with the same records again and again."""
    raw = piece * (size // len(piece))
    return chunk(zstandard.compress(raw, 1), len(raw))


def message(channel, data):
    """A message record."""
    return struct.pack("<BQHIQQ", Opcode.MESSAGE, 22 + len(data), channel, 0, 0, 0) + data


def all_channels(size=ALLOWED):
    """A chunk that describes all numbers of channels, with long metadata."""
    about = {"words": "x" * (size // 65536 - 60)}
    raw = b"".join(written(Channel(n, "/t", "json", about, 0)) for n in range(3, 65536))
    return chunk(zstandard.compress(raw, 1), len(raw))


def bombs(sample):
    """Changes to a sound recording by the name of the bomb; `sample` is a message of channel 1."""
    empty = written(Channel(60000, "", "", {}, 0))
    lists = b"[" + b"[]," * (MIB - 1) + b"[]]"
    names = b"".join(message(9, b'{"%d":1}' % n) for n in range(200_000))
    json = written(Channel(9, "/json", "json", {}, 0))
    pieces = {
        "zstd, 8 GB": chunk(endless_zstd(1 << 33), 1 << 33),
        "zstd, 8 GB, says nothing": chunk(endless_zstd(1 << 33, stated=False), 100),
        "lz4, 1 GB, says nothing": chunk(endless_lz4(1 << 30), 100, "lz4"),
        "shortest messages": packed(message(1, b"")),
        "samples in chunks": b"".join(
            packed(message(1, sample), MIB - number) for number in range(0, 12000, 500)
        ),
        "the same channel again": packed(empty),
        "all channels": all_channels(),
        "nested JSON": json + packed(message(9, lists)),
        "JSON with as many names as messages": json + chunk(zstandard.compress(names), len(names)),
    }
    return {name: inserted(Opcode.DATA_END, 0, 0, piece) for name, piece in pieces.items()}
