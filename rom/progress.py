"""A progress line on standard error that names the phase of a long computation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm


class _Line:
    """The progress line of a context; it appears with the first phase."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.bar: tqdm[Any] | None = None


_line: ContextVar[_Line | None] = ContextVar("line", default=None)


@contextmanager
def phases(title: str, *, shown: bool) -> Iterator[None]:
    """Show the phases of the computation in the context after a title; remove the line at its end.

    Computations of less than a second name no phase and show no line.
    """
    line = _Line(title)
    token = _line.set(line if shown else None)
    try:
        yield
    finally:
        _line.reset(token)
        if line.bar is not None:
            line.bar.close()


def phase(text: str) -> None:
    """Show the phase that begins now: "factorising stiffness, about 1.2 GiB"."""
    line = _line.get()
    if line is None:
        return
    if line.bar is None:
        line.bar = tqdm(bar_format="{desc} [{elapsed}]")
    line.bar.set_description_str(f"{line.title}: {text}")
