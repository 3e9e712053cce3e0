"""The compiled kernel through ctypes: where it is, what its functions take."""

from __future__ import annotations

import ctypes
import importlib.util
from collections.abc import Mapping
from ctypes import POINTER, c_char_p, c_double, c_int32, c_size_t, c_uint64, c_void_p
from typing import Any

from slipmode.rom.kernel.structures import (
    STRUCTURES,
    Branch,
    Contact,
    ContactSamples,
    Curve,
    Discretisation,
    Elastic,
    Forced,
    Full,
    FullSamples,
    HarmonicSum,
    LayoutRow,
    Motion,
    SlowFlow,
    Table,
    TorusMotion,
    TorusPoints,
    Trace,
    TrajectorySteps,
    layout,
)

NAME = "slipmode.rom._core"  # where CMakeLists.txt installs the library

_SIGNATURES: dict[str, list[Any]] = {
    "sm_contact_check": [POINTER(Contact)],
    "sm_elastic_force": [POINTER(Elastic), c_int32, c_void_p, c_void_p, c_void_p],
    "sm_elastic_equilibrium": [
        *(POINTER(Elastic), c_int32, c_void_p, c_void_p, c_void_p, c_void_p),
    ],
    "sm_torus_harmonics": [
        *(POINTER(Contact), POINTER(Discretisation), POINTER(TorusPoints), POINTER(TorusMotion)),
    ],
    "sm_torus_growing": [
        *(POINTER(Contact), POINTER(Discretisation), c_size_t, c_void_p, c_void_p, c_void_p),
    ],
    "sm_contact_motion": [
        *(POINTER(Contact), c_size_t, c_void_p, c_void_p, c_int32, POINTER(ContactSamples)),
    ],
    "sm_harmonic_motion": [
        *(POINTER(HarmonicSum), c_size_t, c_void_p, c_size_t, c_void_p, c_void_p),
    ],
    "sm_table_lookup": [POINTER(Table), c_size_t, c_void_p, c_void_p],
    "sm_slow_flow_rates": [POINTER(SlowFlow), c_size_t, c_void_p, c_void_p, c_void_p],
    "sm_trajectory_bend": [POINTER(SlowFlow), POINTER(TrajectorySteps), c_void_p],
    "sm_trajectory_divide": [POINTER(SlowFlow), POINTER(TrajectorySteps), c_int32, c_void_p],
    "sm_slow_flow_balance": [
        *(POINTER(SlowFlow), c_size_t, c_void_p, c_void_p, c_void_p, c_void_p),
    ],
    "sm_curve_branch": [POINTER(Curve), c_void_p, c_size_t, c_void_p, POINTER(Branch)],
    "sm_curve_specials": [
        *(POINTER(Curve), c_size_t, c_void_p, c_void_p, c_void_p, POINTER(c_size_t)),
    ],
    "sm_curve_passes": [c_int32, c_size_t, c_void_p, c_size_t, c_void_p, c_void_p],
    "sm_forced_curve": [POINTER(Forced), c_double, POINTER(Curve)],
    "sm_forced_search": [POINTER(Forced), c_size_t, c_void_p, POINTER(c_size_t)],
    "sm_component_create": [
        *(POINTER(SlowFlow), POINTER(Contact), POINTER(Motion), c_double, POINTER(c_void_p)),
    ],
    "sm_component_reset": [c_void_p, c_double, c_void_p],
    "sm_component_set_amplitude": [c_void_p, c_void_p],
    "sm_component_set_inputs": [c_void_p, c_void_p],
    "sm_component_step": [c_void_p, c_double],
    "sm_component_advance": [c_void_p, c_double, POINTER(c_double)],
    "sm_component_outputs": [c_void_p, c_void_p],
    "sm_component_slow_outputs": [c_void_p, c_void_p],
    "sm_component_run": [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, POINTER(c_size_t)],
    "sm_component_trace": [c_void_p, c_size_t, c_void_p, c_void_p, POINTER(Trace)],
    "sm_full_march": [
        *(POINTER(Full), c_void_p, c_double, c_void_p, POINTER(FullSamples)),
    ],
    "sm_component_get_state": [c_void_p, c_void_p],
    "sm_component_set_state": [c_void_p, c_void_p],
}


def load() -> ctypes.CDLL:
    """Load the library; its structures must have the layout that Python expects."""
    found = importlib.util.find_spec(NAME)
    if found is None or found.origin is None:
        raise ImportError(f"{NAME}: the compiled kernel is missing; install slipmode again")
    library = ctypes.CDLL(found.origin)
    check_layout(compiled_layout(library))
    for name, arguments in _SIGNATURES.items():
        getattr(library, name).argtypes = arguments
    library.sm_elastic_memory.argtypes = [POINTER(Elastic)]
    library.sm_elastic_memory.restype = c_size_t
    for name in ("sm_component_output_count", "sm_component_state_count"):
        function = getattr(library, name)
        function.argtypes, function.restype = [c_void_p], c_size_t
    library.sm_component_free.argtypes, library.sm_component_free.restype = [c_void_p], None
    library.sm_component_work.argtypes = [c_void_p, POINTER(c_uint64), POINTER(c_uint64)]
    library.sm_component_work.restype = None
    library.sm_message.argtypes, library.sm_message.restype = [c_int32], c_char_p
    return library


Layout = Mapping[str, Mapping[str, tuple[int, int]]]


def compiled_layout(library: ctypes.CDLL) -> Layout:
    """Return offset and size of every field of every structure in the library, as `layout`."""
    if not hasattr(library, "sm_layout"):
        raise ImportError(f"{NAME}: of another version of slipmode; install slipmode again")
    library.sm_layout.argtypes = [POINTER(c_size_t)]
    library.sm_layout.restype = POINTER(LayoutRow)
    count = c_size_t()
    rows = library.sm_layout(ctypes.byref(count))
    found: dict[str, dict[str, tuple[int, int]]] = {}
    for row in rows[: count.value]:
        fields = found.setdefault(row.structure.decode(), {})
        fields[row.field.decode()] = (row.offset, row.size)
    return found


def check_layout(compiled: Layout) -> None:
    """Raise ImportError unless the structures in Python are laid out like the compiled ones."""
    for name, structure in STRUCTURES.items():
        here, there = layout(structure), compiled.get(name, {})
        for field in (*here, *there):
            if here.get(field) != there.get(field):
                place = f"{name}.{field}" if field else name
                raise ImportError(
                    f"{NAME}: {place} is not laid out as in the Python sources, for it was "
                    "compiled from others; install slipmode again"
                )
