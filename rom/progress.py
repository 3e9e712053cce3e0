"""What a long computation is at: one line for people, changed by whatever room is at work."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm

_FORMAT = "{desc} [{elapsed}]"

_title: ContextVar[str | None] = ContextVar("title", default=None)
_line: ContextVar[list[tqdm[Any]] | None] = ContextVar("line", default=None)


@contextmanager
def phases(title: str, *, shown: bool) -> Iterator[None]:
    """Show the phases that the context is told of, behind a title; the line ends with it.

    There is no line before the first phase: computations of less than a second tell of none.
    """
    lines: list[tqdm[Any]] = []
    tokens = _title.set(title), _line.set(lines if shown else None)
    try:
        yield
    finally:
        _title.reset(tokens[0])
        _line.reset(tokens[1])
        for line in lines:
            line.close()


def phase(text: str) -> None:
    """Tell what begins now: "factorising stiffness, about 1.2 GiB"."""
    lines = _line.get()
    if lines is None:
        return
    if not lines:
        lines.append(tqdm(bar_format=_FORMAT))
    lines[0].set_description_str(f"{_title.get()}: {text}")
