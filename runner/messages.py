"""Warnings of a computation as records of the logger "slipmode"."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from slipmode.rom.errors import ValidityWarning, one_line_reason

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
