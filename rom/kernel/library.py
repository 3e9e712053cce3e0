"""The compiled kernel through ctypes: where it is, what its functions take."""

from __future__ import annotations

import ctypes
import hashlib
import importlib.util
import re
from collections.abc import Iterator
from ctypes import POINTER, c_char_p, c_void_p
from typing import Any

import numpy as np

from slipmode.rom.kernel.structures import DECLARATIONS, HEADERS, STRUCTURES, TYPES, address

NAME = "slipmode.rom._core"  # where CMakeLists.txt installs the library

# What may be an array.
_IN_ARRAYS = {"double", "sm_inputs", "sm_segment", "sm_element"}


class _Array:
    """Type of an argument that is an array, an address or None."""

    def __init__(self, name: str, kind: str) -> None:
        self._name, self._kind = name, kind

    def from_param(self, value: Any) -> Any:
        """Return what ctypes passes."""
        if isinstance(value, np.ndarray):
            value = address(self._name, self._kind, value)
        return c_void_p.from_param(value)


def _argument(declaration: str) -> Any:
    """Return the ctype of an argument as C declares it: "const sm_table *table"."""
    kind, name = declaration.removeprefix("const ").split()
    if not name.startswith("*"):
        return TYPES[kind]
    pointed = {**TYPES, **STRUCTURES}.get(kind)
    if pointed is None or name.startswith("**"):
        return c_void_p
    return _Array(name[1:], kind) if kind in _IN_ARRAYS else POINTER(pointed)


def functions() -> Iterator[tuple[str, Any, list[Any]]]:
    """Yield names, result and arguments of the functions that slipmode.h declares."""
    results = {**TYPES, "void": None, "char": c_char_p}
    for kind, name, declared in re.findall(
        r"SM_API (?:const )?(\w+) \*?(\w+)\(([^)]*)\);", DECLARATIONS
    ):
        arguments = [] if declared == "void" else declared.split(",")
        yield name, results[kind], [_argument(" ".join(each.split())) for each in arguments]


def load() -> ctypes.CDLL:
    """Load the library; it must be compiled from the headers that are here."""
    found = importlib.util.find_spec(NAME)
    if found is None or found.origin is None:
        raise ImportError(f"{NAME}: the compiled kernel is missing; install slipmode again")
    library = ctypes.CDLL(found.origin)
    check_headers(library)
    for name, result, arguments in functions():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def check_headers(library: ctypes.CDLL) -> None:
    """Raise ImportError unless the library was compiled from the headers that are here."""
    here = "".join(hashlib.sha256(header.read_bytes()).hexdigest() for header in HEADERS)
    compiled: Any = getattr(library, "sm_compiled_headers", None)
    if compiled:
        compiled.restype = c_char_p
    if not compiled or compiled() != here.encode():
        raise ImportError(
            f"{NAME}: is compiled from another version of slipmode.h; install slipmode again"
        )
