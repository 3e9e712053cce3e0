"""Opening a recording for reading: one clear line where that cannot be."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from os import PathLike
from typing import BinaryIO

from mcap.writer import MCAP0_MAGIC

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.files import as_path


@contextmanager
def opened(path: str | PathLike[str]) -> Iterator[BinaryIO]:
    """An MCAP file for reading, behind its magic; refusals within name the file.

    Raises
    ------
    SlipmodeError
        If it cannot be opened, or does not begin like MCAP.
    """
    with ExitStack() as stack:
        try:
            file = stack.enter_context(as_path("path", path).open("rb"))
        except OSError as error:
            raise SlipmodeError(f"{path}: {error.strerror}") from error
        with naming(path):
            magic = file.read(len(MCAP0_MAGIC))
            if magic != MCAP0_MAGIC:
                raise SlipmodeError("not an MCAP file" if magic else "an empty file")
            yield file


@contextmanager
def naming(path: str | PathLike[str]) -> Iterator[None]:
    """Let refusals within name the file."""
    try:
        yield
    except SlipmodeError as error:
        raise SlipmodeError(f"{path}: {error}") from error
