"""The structures of slipmode.h, as ctypes and as columns of arrays.

They are read from the header, which says what each field is.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator
from ctypes import CFUNCTYPE, POINTER, c_double, c_int, c_int32, c_size_t, c_uint64, c_void_p
from functools import cache
from math import prod
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

HEADERS = tuple(
    Path(__file__).with_name(name) for name in ("slipmode.h", "slipmode_full.h", "slipmode_tone.h")
)
DECLARATIONS = re.sub(r"/\*.*?\*/", "", "".join(map(Path.read_text, HEADERS)), flags=re.DOTALL)
_NUMBERS = dict(re.findall(r"#define SM_(\w+) (\d+)", DECLARATIONS))

CurveRates = CFUNCTYPE(c_int32, c_void_p, *[POINTER(c_double)] * 3)  # sm_curve_rates

TYPES: dict[str, Any] = {
    **{"int": c_int, "int32_t": c_int32, "size_t": c_size_t, "double": c_double},
    **{"uint64_t": c_uint64, "sm_status": c_int32, "sm_curve_rates": CurveRates},
}


@cache
def _dtypes(kind: str) -> list[np.dtype[Any]]:
    """Return the types of arrays for a pointer to what C calls `kind`.

    Complex numbers are pairs of doubles. Rows of doubles may be structures of doubles.
    """
    own = np.dtype(TYPES.get(kind) or STRUCTURES[kind])
    if kind == "double":
        return [own, np.dtype(complex)]
    of_doubles = own.names and all(own[name].base.kind == "f" for name in own.names)
    return [own, np.dtype(float)] if of_doubles else [own]


def address(name: str, kind: str, array: np.ndarray) -> int:
    """Return the address of an array for a pointer that C declares as `kind *name`.

    Arrays must be C-contiguous, and of a type in `_dtypes`.
    """
    if array.dtype not in _dtypes(kind) or not array.flags.c_contiguous:
        contiguous = "" if array.flags.c_contiguous else ", which is not contiguous"
        raise TypeError(
            f"{name}: must be a C-contiguous array of {kind}, got {array.dtype}{contiguous}"
        )
    return int(array.ctypes.data)


class Structure(ctypes.Structure):
    """A structure of the core, made from numbers, and from arrays and structures for its pointers.

    It keeps these alive as `owned`, by the names of their fields, and takes no other attribute
    than that and its fields.
    """

    __slots__ = ("owned",)
    pointers: ClassVar[dict[str, str]] = {}  # fields, and what C declares that they point to

    def __init__(self, *values: Any, **fields: Any) -> None:
        fields |= zip((name for name, *_ in self._fields_), values, strict=False)
        self.owned: dict[str, Any] = {}
        for name, value in fields.items():
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a field; refuse arrays of another type, and integers that do not fit."""
        stored = value
        if isinstance(value, np.ndarray):
            self.owned[name] = value
            stored = address(name, self.pointers[name], value)
        elif isinstance(value, Structure):
            self.owned[name] = value
            stored = ctypes.addressof(value) if name in self.pointers else value
        super().__setattr__(name, stored)
        if isinstance(stored, int) and getattr(self, name) != stored and name not in self.pointers:
            raise OverflowError(f"{name} = {stored}: does not fit in the integer of the core")


def _fields(declarations: str) -> Iterator[tuple[str, Any]]:
    """Yield names and ctypes of fields as C declares them: "double a, b[2]; const double *c;"."""
    for kind, declared in re.findall(r"(?:const )?(\w+) ([^;]+);", declarations):
        for pointer, name, sizes in re.findall(r"(\*?)(\w+)((?:\[[^]]+\])*)", declared):
            field: Any = c_void_p if pointer else TYPES.get(kind) or STRUCTURES[kind]
            for size in reversed(re.findall(r"\[([^]]+)\]", sizes)):
                factors = size.replace("SM_", "").split(" * ")
                field *= prod(int(_NUMBERS.get(factor, factor)) for factor in factors)
            yield name, field


def _pointers(declarations: str) -> Iterator[tuple[str, str]]:
    """Yield names of fields that are pointers, and what they point to."""
    for kind, declared in re.findall(r"(?:const )?(\w+) ([^;]+);", declarations):
        yield from ((name, kind) for name in re.findall(r"\*(\w+)", declared))


STRUCTURES: dict[str, type[Structure]] = {}  # by their names in C
for _body, _name in re.findall(r"typedef struct \{(.*?)\} (\w+);", DECLARATIONS, re.DOTALL):
    members: dict[str, Any] = {"__slots__": (), "_fields_": list(_fields(_body))}
    members["pointers"] = dict(_pointers(_body))
    STRUCTURES[_name] = type(_name, (Structure,), members)

MODES = int(_NUMBERS["MODES"])
OUTPUTS_FIXED = int(_NUMBERS["OUTPUTS_FIXED"])

Contact = STRUCTURES["sm_contact"]
Elastic = STRUCTURES["sm_elastic"]
ModalResponse = STRUCTURES["sm_modal_response"]
Discretisation = STRUCTURES["sm_discretisation"]
TorusPoints = STRUCTURES["sm_torus_points"]
TorusMotion = STRUCTURES["sm_torus_motion"]
Table = STRUCTURES["sm_table"]
Combination = STRUCTURES["sm_combination"]
SlowFlow = STRUCTURES["sm_slow_flow"]
Curve = STRUCTURES["sm_curve"]
Branch = STRUCTURES["sm_branch"]
Forced = STRUCTURES["sm_forced"]
Motion = STRUCTURES["sm_motion"]
Full = STRUCTURES["sm_full"]
Tone = STRUCTURES["sm_tone"]
ToneModes = STRUCTURES["sm_tone_modes"]
ToneCarrier = STRUCTURES["sm_tone_carrier"]
FullSamples = STRUCTURES["sm_full_samples"]
ContactSamples = STRUCTURES["sm_contact_samples"]
Trace = STRUCTURES["sm_trace"]
HarmonicSum = STRUCTURES["sm_harmonic_sum"]

# Structures of which there are many are rows of an array.
INPUTS = np.dtype(STRUCTURES["sm_inputs"])
ELEMENT = np.dtype(STRUCTURES["sm_element"])
SEGMENT = np.dtype(STRUCTURES["sm_segment"])
INPUT_QUANTITIES = ("force", "frequency", "phase")
INPUT_FIELDS = tuple(name + rate for name in INPUT_QUANTITIES for rate in ("", "_rate"))
SCALE_FIELDS = ("limit_scale", "limit_scale_rate")  # of all contacts, not of a mode
