"""The records of an MCAP file with its chunks unpacked, some steps ahead in a thread beside."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import BinaryIO

from mcap import records

from slipmode.runner.recording.mcapfile.chunk import Contents, single, unpack
from slipmode.runner.recording.mcapfile.scan import DamagedError, Index, StoredChunk, scan

_STEPS = 3  # enough that neither waits for the other

Unpacked = Contents | records.McapRecord | Index | None


def unpacked(file: BinaryIO) -> Iterator[Unpacked]:
    """Records in the order of the file, chunks as their contents.

    Raises
    ------
    DamagedError
        At the first record or chunk that cannot be read, after all before it.
    """
    waiting: deque[Future[Contents] | records.McapRecord | Index | None] = deque()
    damage = None
    with ThreadPoolExecutor(max_workers=1) as pool:
        try:
            for piece in scan(file):
                match piece.record:
                    case StoredChunk() as chunk:
                        waiting.append(pool.submit(unpack, chunk))
                    case records.Message() as message:
                        waiting.append(pool.submit(single, message))
                    case record:
                        waiting.append(record)
                if len(waiting) > _STEPS:
                    yield _result(waiting.popleft())
        except DamagedError as error:
            damage = error
        while waiting:
            yield _result(waiting.popleft())
    if damage is not None:
        raise damage


def take_all(file: BinaryIO, take: Callable[[Unpacked], None]) -> str:
    """Hand every record to `take`; what damage put an end to that, "" if none did."""
    try:
        for record in unpacked(file):
            take(record)
    except DamagedError as error:
        return str(error)
    return ""


def _result(item: Future[Contents] | records.McapRecord | Index | None) -> Unpacked:
    return item.result() if isinstance(item, Future) else item
