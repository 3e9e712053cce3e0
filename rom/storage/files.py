"""Files that are written completely or not at all, or locked while they are written."""

from __future__ import annotations

import os
import secrets
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Any, BinaryIO

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


def create_file(path: Path) -> IO[bytes]:
    """Create a file for writing, locked against other runs until it is closed.

    A file, or a link to one, is replaced: what the link points to stays as it is. Devices are
    written to. The lock ends with the process, however that ends. Without locks (Windows, some
    network drives) the file is not locked. Raises SlipmodeError if the path is a directory, or
    another run is writing the file, which stays as it is; OSError if the file cannot be written.
    """
    if path.is_dir():
        raise SlipmodeError(f"{path}: is a directory; give the name of a file to record to")
    flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_BINARY", 0)  # which Windows needs
    if path.is_file() or not path.exists():
        flags |= os.O_EXCL
        with suppress(FileNotFoundError), ExitStack() as stack:
            if not path.is_symlink() and sys.platform != "win32":
                _lock(stack.enter_context(path.open("rb")), path)
            path.unlink()
    file = os.fdopen(os.open(path, flags, 0o666), "wb")
    _lock(file, path)
    return file


def _lock(file: IO[bytes], path: Path) -> None:
    """Lock a file against other runs; close and refuse it if another run has locked it."""
    if sys.platform == "win32":
        return
    import fcntl

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise SlipmodeError(
            f"{path}: another run is writing this file; wait until it ends, or write to "
            "another folder"
        ) from None
    except OSError:
        pass  # a file system without locks
