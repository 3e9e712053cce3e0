"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from slipmode.rom.arrays import in_one_line
from slipmode.rom.errors import SlipmodeError

PART = ".part"  # how the name of an unfinished file ends


def as_path(key: str, given: str | os.PathLike[str]) -> Path:
    """Return a path that a user gives.

    Raises
    ------
    SlipmodeError
        If it is neither a string nor a path. The message names `key`.
    """
    if not isinstance(given, str | os.PathLike):
        raise SlipmodeError(f"{key}: must be a string or a path, got {in_one_line(given)}")
    return Path(given)


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A new file, to be filled in the context, that takes the place of `path` at its end.

    Whoever opens `path` meanwhile finds what was there before. If the context ends in an
    exception, nothing has happened. Every call has an unfinished file of its own, so threads and
    processes may write the same path: the last one stays.

    Raises
    ------
    OSError
        If the file cannot be written; it names `path`.
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
