"""Messages that an FMU logs while FMPy steps it.

FMPy formats the messages of FMI 2.0 in one function of the process, which passes all of them to
the logger that it received last, even if that was freed. This module has one logger for all
instances, which lasts as long as the process and identifies instances by their environment.
"""

from __future__ import annotations

from ctypes import byref
from itertools import count
from typing import Any
from weakref import WeakValueDictionary

from slipmode.rom.extras import extra

fmi1 = extra("fmpy.fmi1", "fmu")
fmi2 = extra("fmpy.fmi2", "fmu")
native = extra("fmpy.logging", "fmu")


class Log:
    """The last reason that an FMU logged for a refused call."""

    def __init__(self) -> None:
        self._last = ""

    def write(self, *arguments: Any) -> None:
        """Logger of either version of the standard."""
        status, _, message = arguments[-3:]
        if status >= 2:  # discard, error or fatal
            self._last = message.decode(errors="replace")

    def reason(self, error: Exception) -> str:
        """Return the reason logged since the last reading, else the message of the error."""
        reason, self._last = self._last or str(error), ""
        return reason

    def callbacks(self) -> Any:
        """Return callback functions for an instance of FMI 2.0 that logs here."""
        environment = next(_environments)
        _logs[environment] = self
        # FMPy's memory functions last as long as the process too
        callbacks = fmi2.fmi2CallbackFunctions(
            logger=_route,
            allocateMemory=fmi2.defaultCallbacks.allocateMemory,
            freeMemory=fmi2.defaultCallbacks.freeMemory,
            componentEnvironment=environment,
        )
        native.addLoggerProxy(byref(callbacks))
        return callbacks


_environments = count(1)
_logs: WeakValueDictionary[int, Log] = WeakValueDictionary()


def _to_its_log(environment: int | None, *arguments: Any) -> None:
    log = _logs.get(environment or 0)
    if log is None:
        fmi1.printLogMessage(environment, *arguments)
    else:
        log.write(*arguments)


_route = fmi2.fmi2CallbackLoggerTYPE(_to_its_log)
