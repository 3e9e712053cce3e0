"""Ctrl-C between two samples of a recording."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interrupts_held_back() -> Iterator[Callable[[], None]]:
    """Hold back the first Ctrl-C until the yielded function is called, or the context ends.

    A recording then ends with a whole sample. A second Ctrl-C acts at once. Outside the main
    thread, where Ctrl-C never arrives, and where it is ignored, nothing changes.
    """
    pending = False
    previous = signal.getsignal(signal.SIGINT)

    def hold_back(signal_number: int, frame: FrameType | None) -> None:
        nonlocal pending
        pending = True
        signal.signal(signal.SIGINT, previous)

    def raise_if_pending() -> None:
        if pending:
            raise KeyboardInterrupt

    if not callable(previous) or threading.current_thread() is not threading.main_thread():
        yield raise_if_pending
        return
    signal.signal(signal.SIGINT, hold_back)
    try:
        yield raise_if_pending
    finally:
        signal.signal(signal.SIGINT, previous)
    raise_if_pending()
