"""The peers that are written in C."""

from __future__ import annotations

import ctypes
import importlib.util
from functools import cache

from slipmode.rom import kernel


@cache
def library() -> ctypes.CDLL:
    """The compiled peers."""
    found = importlib.util.find_spec("slipmode.runner.report.peers._peers")
    if found is None or found.origin is None:
        raise ImportError("slipmode.runner.report.peers._peers is missing; install slipmode again")
    loaded = ctypes.CDLL(found.origin)
    contact = ctypes.POINTER(kernel.Contact)
    loaded.peer_paper_scheme.argtypes = [
        *(contact, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32),
        *(ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p),
    ]
    loaded.peer_bare_contacts.argtypes = [
        *(contact, ctypes.c_double, ctypes.c_int32, ctypes.c_int32, ctypes.c_int32),
        *(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p),
    ]
    pointer, number, count = ctypes.c_void_p, ctypes.c_double, ctypes.c_size_t
    loaded.peer_newmark.argtypes = [
        *(ctypes.c_int32, ctypes.c_int32, pointer, pointer, pointer, pointer, number, pointer),
        *(pointer, pointer, number, count, count, ctypes.c_int32, pointer, pointer, pointer),
    ]
    loaded.peer_first_order_rate.argtypes = [pointer, number, pointer, pointer]
    loaded.peer_first_order_jacobian.argtypes = [pointer, pointer, pointer]
    for returns_nothing in (loaded.peer_first_order_rate, loaded.peer_first_order_jacobian):
        returns_nothing.restype = None
    return loaded
