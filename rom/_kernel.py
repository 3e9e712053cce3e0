"""The C core through ctypes: structures, signatures and status codes of kernel/slipmode.h."""

from __future__ import annotations

import ctypes
import importlib.util
from ctypes import POINTER, Structure, c_char_p, c_double, c_int32, c_size_t, c_uint64, c_void_p
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import SlipmodeError

MODES = 2
NEAR = 8
OUTPUTS_FIXED = 10

OK = 0
OUTSIDE_TABLE = 5


class Contact(Structure):
    """sm_contact."""

    _fields_ = (
        ("contacts", c_int32),
        ("modes", c_int32),
        ("law", c_int32),
        ("alpha", c_double),
        ("limit", c_void_p),
        ("stiffness", c_void_p),
        ("damping", c_void_p),
        ("coupling", c_void_p),
        ("mass", c_void_p),
        ("response", c_void_p),
    )


class ModalResponse(Structure):
    """sm_modal_answer."""

    _fields_ = (
        ("orders_count", c_int32),
        ("orders", c_void_p),
        ("reaction", c_void_p),
    )


class Table(Structure):
    """sm_table."""

    _fields_ = (
        ("modes", c_int32),
        ("combinations", c_int32),
        ("power", c_int32),
        ("count_a", c_int32),
        ("count_b", c_int32),
        ("node_a", c_void_p),
        ("node_b", c_void_p),
        ("values", c_void_p),
        ("rate_correction", c_void_p),
        ("region", c_void_p),
    )


class Near(Structure):
    """sm_near."""

    _fields_ = (("mode", c_int32), ("n", c_int32), ("m", c_int32))


class SlowFlow(Structure):
    """sm_slow_flow."""

    _fields_ = (
        ("paper", c_int32),
        ("natural", c_double * MODES),
        ("damping", c_double * MODES),
        ("table", Table),
        ("factor", (c_double * 2 * 2) * MODES),
        ("shift", (c_double * 2) * MODES),
        ("cross_response", (c_double * 2 * MODES) * MODES),
        ("combinations", Near * NEAR),
    )


class Motion(Structure):
    """sm_motion."""

    _fields_ = (
        ("wanted", c_int32),
        ("elastic", c_int32),
        ("modes_out", c_void_p),
        ("contacts_out", c_void_p),
        ("orders_count", c_int32),
        ("orders", c_void_p),
        ("reaction", c_void_p),
        ("response", c_void_p),
        ("steps_per_period", c_int32),
        ("memory_periods", c_double),
    )


class Full(Structure):
    """sm_full."""

    _fields_ = (
        ("coordinates", c_int32),
        ("contacts", c_int32),
        ("modes", c_int32),
        ("outputs", c_int32),
        ("law", c_int32),
        ("diagonal", c_int32),
        ("alpha", c_double),
        ("step", c_double),
        ("limit", c_void_p),
        ("stiffness", c_void_p),
        ("damping", c_void_p),
        ("directions", c_void_p),
        ("patterns", c_void_p),
        ("output", c_void_p),
        ("inverse", c_void_p),
        ("resistance", c_void_p),
    )


class HarmonicSum(Structure):
    """sm_harmonic_sum."""

    _fields_ = (
        ("modes", c_int32),
        ("orders_count", c_int32),
        ("orders", c_void_p),
        ("signals", c_size_t),
        ("shape", c_void_p),
        ("coefficient", c_void_p),
    )


# sm_inputs and sm_segment are arrays of doubles: columns of a float64 array.
INPUT_QUANTITIES = ("force", "frequency", "phase")
INPUT_FIELDS = tuple(name + rate for name in INPUT_QUANTITIES for rate in ("", "_rate"))
SCALE_FIELDS = ("limit_scale", "limit_scale_rate")  # of all contacts, not of a mode
INPUTS = np.dtype(
    [
        *((name, float, MODES) for name in INPUT_FIELDS),
        *((name, float) for name in SCALE_FIELDS),
        ("angle", float, MODES),
    ]
)
SEGMENT = np.dtype(
    [
        ("start", float),
        ("duration", float),
        ("amplitude_start", complex, MODES),
        ("amplitude_end", complex, MODES),
        ("rate_start", complex, MODES),
        ("rate_end", complex, MODES),
        ("angle", float, MODES),
        ("frequency", float, MODES),
        ("frequency_rate", float, MODES),
        ("reaction_start", np.uintp),
        ("reaction_end", np.uintp),
    ]
)

_SIGNATURES: dict[str, list[Any]] = {
    "sm_contact_check": [POINTER(Contact)],
    "sm_torus_harmonics": [
        *(POINTER(Contact), c_void_p, c_int32, c_int32, c_double, c_void_p, c_int32),
        *(c_size_t, c_void_p, c_int32, c_void_p),
        *(c_void_p, c_void_p, c_void_p, c_void_p),
    ],
    "sm_torus_growing": [
        *(POINTER(Contact), c_void_p, c_int32, c_int32),
        *(c_size_t, c_void_p, c_void_p, c_int32, c_void_p, c_void_p),
    ],
    "sm_contact_motion": [
        *(POINTER(Contact), c_size_t, c_void_p, c_void_p, c_int32),
        *(c_size_t, c_void_p, c_void_p, c_void_p, c_void_p),
    ],
    "sm_harmonic_motion": [
        *(POINTER(HarmonicSum), c_size_t, c_void_p, c_size_t, c_void_p, c_void_p),
    ],
    "sm_table_lookup_many": [POINTER(Table), c_size_t, c_void_p, c_void_p],
    "sm_slow_flow_rate": [
        *(POINTER(SlowFlow), c_void_p, c_double),
        *(c_void_p, c_void_p, POINTER(c_double), POINTER(c_double)),
    ],
    "sm_component_create": [
        *(POINTER(SlowFlow), POINTER(Contact), POINTER(Motion), c_double, POINTER(c_void_p)),
    ],
    "sm_component_reset": [c_void_p, c_double, c_void_p],
    "sm_component_set_inputs": [c_void_p, c_void_p],
    "sm_component_step": [c_void_p, c_double],
    "sm_component_outputs": [c_void_p, c_void_p],
    "sm_component_run": [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, POINTER(c_size_t)],
    "sm_full_march": [
        *(POINTER(Full), c_void_p, c_double, c_size_t, c_size_t),
        *(c_void_p, c_void_p, c_void_p, c_void_p, c_void_p),
    ],
    "sm_component_get_state": [c_void_p, c_void_p],
    "sm_component_set_state": [c_void_p, c_void_p],
}


def _load() -> ctypes.CDLL:
    core = importlib.util.find_spec("slipmode.rom._core")
    if core is None or core.origin is None:
        raise ImportError(
            "slipmode.rom._core: the compiled core is missing; install slipmode again"
        )
    library = ctypes.CDLL(core.origin)
    for name, arguments in _SIGNATURES.items():
        getattr(library, name).argtypes = arguments
    for name in ("sm_component_output_count", "sm_component_state_count"):
        function = getattr(library, name)
        function.argtypes, function.restype = [c_void_p], c_size_t
    library.sm_component_free.argtypes, library.sm_component_free.restype = [c_void_p], None
    library.sm_component_work.argtypes = [c_void_p, POINTER(c_uint64), POINTER(c_uint64)]
    library.sm_component_work.restype = None
    library.sm_message.argtypes, library.sm_message.restype = [c_int32], c_char_p
    return library


lib = _load()


def message(status: int) -> str:
    """What a status means, in words."""
    return str(lib.sm_message(status).decode())


def check(status: int, doing: str) -> None:
    """Raise SlipmodeError unless the status is OK."""
    if status != OK:
        raise SlipmodeError(f"{doing}: {message(status)}")


def inputs(count: int) -> NDArray[np.void]:
    """`count` sm_inputs: no force, frequencies of 1 rad/s, friction limits as tabulated."""
    made = np.zeros(count, dtype=INPUTS)
    made["frequency"] = 1.0
    made["limit_scale"] = 1.0
    return made


def contiguous(values: Any) -> Floats:
    """A C-contiguous float64 array that the core can read."""
    return np.ascontiguousarray(values, dtype=float)


def table(
    modes: int,
    node_a: Floats,
    node_b: Floats,
    values: Floats,
    rate_correction: Floats | None,
    region: Flags | None,
) -> Table:
    """sm_table over the given contiguous arrays, which it keeps alive."""
    columns = values.shape[-1] // 2
    power = int(columns > modes)
    result = Table(
        modes=modes,
        combinations=columns - modes - power,
        power=power,
        count_a=node_a.size,
        count_b=node_b.size,
        node_a=node_a.ctypes.data,
        node_b=node_b.ctypes.data if modes == 2 else None,
        values=values.ctypes.data,
        rate_correction=None if rate_correction is None else rate_correction.ctypes.data,
        region=None if region is None else region.ctypes.data,
    )
    result.owned = (node_a, node_b, values, rate_correction, region)
    return result
