"""The compiled kernel through ctypes: where it is, what its functions take."""

from __future__ import annotations

import ctypes
import hashlib
import importlib.util
from ctypes import c_char_p
from typing import Any

from slipmode.rom.kernel.structures import DECLARATIONS, HEADERS, TYPES, argument, declared

NAME = "slipmode.rom._core"  # where CMakeLists.txt installs the library


def load() -> ctypes.CDLL:
    """Load the library; it must be compiled from the headers that are here."""
    found = importlib.util.find_spec(NAME)
    if found is None or found.origin is None:
        raise ImportError(f"{NAME}: the compiled kernel is missing; install slipmode again")
    library = ctypes.CDLL(found.origin)
    check_headers(library)
    for part in DECLARATIONS.split("SM_API ")[1:]:
        declaration, _, rest = part.partition("(")
        ((name, kind, stars, _),) = declared(declaration)
        function = getattr(library, name)
        function.restype = c_char_p if stars else TYPES.get(kind)  # None: void
        function.argtypes = [argument(each) for each in rest.partition(")")[0].split(",")]
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
