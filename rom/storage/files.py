"""Files that are written completely or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import in_one_line
from slipmode.rom.errors import SlipmodeError

PART = ".part"  # ending of unfinished files


def as_path(key: str, given: str | os.PathLike[str]) -> Path:
    """Return a user's path; refuse, naming `key`, what is neither a string nor a path."""
    if not isinstance(given, str | os.PathLike):
        raise SlipmodeError(f"{key}: must be a string or a path, got {in_one_line(given)}")
    return Path(given)


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a new file to fill in the context; it replaces `path` at the end of the context.

    Until then, or if the context ends in an exception, `path` is unchanged. Threads and processes
    may write the same path, because every call has its own unfinished file: the last one stays.
    An OSError names `path`.
    """
    target = Path(path)
    unfinished = target.with_name(f".slipmode-{secrets.token_hex(8)}{PART}")
    try:
        with unfinished.open("xb") as file:
            yield file
        unfinished.replace(target)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(target)) from error
    finally:
        with suppress(OSError):
            unfinished.unlink()


def write_columns(path: str | os.PathLike[str], columns: Mapping[str, NDArray[Any]]) -> None:
    """Write columns of numbers by their names as a .csv file, which replaces `path`."""
    numbers = np.column_stack(list(columns.values()))
    with replacing(path) as file:
        np.savetxt(file, numbers, delimiter=",", header=",".join(columns), comments="")
