"""Progress on standard error: a line that names the phase of a computation, and bars."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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
        line.bar = progress_bar(bar_format="{desc} [{elapsed}]")
    line.bar.set_description_str(f"{line.title}: {text}")


def progress_bar(
    iterable: Iterable[Any] | None = None, *, shown: bool = True, **options: Any
) -> tqdm[Any]:
    """Return a bar of tqdm, which is imported for the first one."""
    from tqdm import tqdm

    bar: tqdm[Any] = tqdm(iterable, disable=not shown, **options)
    return bar
