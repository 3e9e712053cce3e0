"""Warnings of a computation as records of the logger "slipmode"; errors in one line."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from slipmode.rom.errors import SlipmodeError, ValidityWarning, one_line_reason

_log = logging.getLogger("slipmode")


@contextmanager
def warnings_to(handler: logging.Handler) -> Iterator[None]:
    """Pass records of slipmode, and warnings as records of one line, to a handler."""

    def show(message: Warning | str, *_where: object, **_more: object) -> None:
        _log.warning("%s", one_line_reason(message))

    _log.addHandler(handler)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", ValidityWarning)
            warnings.showwarning = show
            yield
    finally:
        _log.removeHandler(handler)


def one_line(error: BaseException) -> str:
    """Return in one line the reason that an error gives, with its class if it is unexpected."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted by the user"
    words = one_line_reason(error)
    if isinstance(error, (SlipmodeError, OSError)) and words:
        return words
    return f"{type(error).__name__}: {words}" if words else type(error).__name__
