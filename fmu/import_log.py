"""What an FMU logs while FMPy drives it.

FMPy formats the messages of FMI 2.0 in one function of the process, which passes them all on to
the logger that it was given last, whether that is still there or not. Ours is one for all
instances and lasts as long as the process; it tells them apart by their environment.
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

_DISCARD = 2  # status from which on a message says what went wrong


class Log:
    """The last reason that an FMU gave for not doing what it was asked."""

    def __init__(self) -> None:
        self._last = ""

    def write(self, *said: Any) -> None:
        """Logger of either version of the standard."""
        status, _, message = said[-3:]
        if status >= _DISCARD:
            self._last = message.decode(errors="replace")

    def reason(self, error: Exception) -> str:
        """What was logged since it was last asked for, else what the error says."""
        reason, self._last = self._last or str(error), ""
        return reason

    def callbacks(self) -> Any:
        """Callback functions for an instance of FMI 2.0 that logs here."""
        environment = next(_environments)
        _logs[environment] = self
        # FMPy's own memory functions, which have to last just as long
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


def _to_its_log(environment: int | None, *said: Any) -> None:
    log = _logs.get(environment or 0)
    if log is None:
        fmi1.printLogMessage(environment, *said)
    else:
        log.write(*said)


_route = fmi2.fmi2CallbackLoggerTYPE(_to_its_log)
