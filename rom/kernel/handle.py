"""Objects of the core that have a state: they are made, called by their address, and freed."""

from __future__ import annotations

import ctypes
import weakref
from functools import partial
from typing import Any

from slipmode.rom import kernel


class Handle:
    """An object of the core, which is freed with its handle.

    Its methods are the functions of the core `sm_<kind>_<name>` without their first argument.

    Parameters
    ----------
    kind : str
        Beginning of the names of its functions, "component" or "tone".
    *parts : Structure
        Structures that it is made of; they and their arrays are kept alive.
    tolerance : float
        Relative tolerance of its steps [-].
    """

    def __init__(self, kind: str, *parts: kernel.Structure, tolerance: float) -> None:
        self._kind, self._parts, self._address = kind, parts, ctypes.c_void_p()
        status = self._function("create")(*parts, tolerance, ctypes.byref(self._address))
        kernel.check(status, kind)
        weakref.finalize(self, self._function("free"), self._address.value)

    def __getattr__(self, name: str) -> Any:
        """Return a function of the core, which is called with this object."""
        if name.startswith("_"):
            raise AttributeError(name)
        call = vars(self)[name] = partial(self._function(name), self._address)
        return call

    def _function(self, name: str) -> Any:
        return getattr(kernel.lib, f"sm_{self._kind}_{name}")
