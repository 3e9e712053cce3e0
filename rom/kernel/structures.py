"""The declarations of slipmode.h in ctypes, and the types of the arrays that pointers take.

They are read from the header, which says what each field and each argument is.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from ctypes import CFUNCTYPE, POINTER, c_double, c_int, c_int32, c_size_t, c_uint64, c_void_p
from math import prod
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

HEADERS = tuple(
    Path(__file__).with_name(f"slipmode{part}.h")
    for part in ("", "_slow", "_component", "_full", "_tone")
)
# A comment ends, and what C reads begins, at the first "*/" of each part that "/*" begins.
_TEXT = "*/" + "".join(map(Path.read_text, HEADERS))
_LINES = "".join(part.partition("*/")[2] for part in _TEXT.split("/*")).splitlines()
#: The declarations, without comments and lines of the preprocessor.
DECLARATIONS = "\n".join(line for line in _LINES if not line.startswith("#"))
_NUMBERS = dict(line.split()[1:] for line in _LINES if len(line.split()) == 3 and "#" in line)

CurveRates = CFUNCTYPE(c_int32, c_void_p, *[POINTER(c_double)] * 3)  # sm_curve_rates

#: What C calls a type, and what it is in ctypes; the structures are added as they are declared.
TYPES: dict[str, Any] = {
    **{"int": c_int, "int32_t": c_int32, "size_t": c_size_t, "double": c_double},
    **{"uint64_t": c_uint64, "sm_status": c_int32, "sm_curve_rates": CurveRates},
}


def address(name: str, kind: str, value: np.ndarray | Structure) -> int:
    """Return the address of an array or a structure for a pointer that C declares as `kind *name`.

    Arrays must be C-contiguous, and of a type in `_ARRAYS`.
    """
    if isinstance(value, Structure):
        if type(value) is not TYPES[kind]:
            raise TypeError(f"{name}: must be {kind}, got {type(value).__name__}")
        return ctypes.addressof(value)
    if value.dtype not in _ARRAYS.get(kind, ()) or not value.flags.c_contiguous:
        contiguous = "" if value.flags.c_contiguous else ", which is not contiguous"
        raise TypeError(
            f"{name}: must be a C-contiguous array of {kind}, got {value.dtype}{contiguous}"
        )
    return int(value.ctypes.data)


class _Array:
    """Type of an argument that is an array, an address or None."""

    def __init__(self, name: str, kind: str) -> None:
        self._name, self._kind = name, kind

    def from_param(self, value: Any) -> Any:
        """Return what ctypes passes."""
        if isinstance(value, np.ndarray):
            value = address(self._name, self._kind, value)
        return c_void_p.from_param(value)


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
        if isinstance(value, np.ndarray | Structure):
            self.owned[name] = value
            if name in self.pointers:
                stored = address(name, self.pointers[name], value)
        super().__setattr__(name, stored)
        if isinstance(stored, int) and getattr(self, name) != stored:
            raise OverflowError(f"{name} = {stored}: does not fit in the integer of the core")


def declared(declaration: str) -> Iterator[tuple[str, str, int, list[str]]]:
    """Yield names, types, numbers of stars and sizes in C: of a and b in "const int *a, b[2]"."""
    kind, declarators = declaration.strip().removeprefix("const ").split(maxsplit=1)
    for declarator in declarators.split(","):
        pointer, *sizes = declarator.replace("]", "").split("[")
        yield pointer.strip(" *\n"), kind, pointer.count("*"), sizes


def argument(declaration: str) -> Any:
    """Return the ctype of an argument as C declares it: "const sm_table *table"."""
    ((name, kind, stars, _),) = declared(declaration)
    if kind not in TYPES:  # an object whose fields only the core knows
        return c_void_p
    if not stars:
        return TYPES[kind]
    return _Array(name, kind) if kind in _ARRAYS else POINTER(TYPES[kind])


def _structure(name: str, body: str) -> type[Structure]:
    """Return a structure of this name in C with the fields that its body declares."""
    fields: dict[str, Any] = {}
    pointers: dict[str, str] = {}
    for declaration in body.split(";")[:-1]:
        for field, kind, stars, sizes in declared(declaration):
            fields[field] = c_void_p if stars else TYPES[kind]
            for size in reversed(sizes):
                fields[field] *= prod(int(_NUMBERS.get(each, each)) for each in size.split(" * "))
            if stars:
                pointers[field] = kind
    members = {"__slots__": (), "_fields_": list(fields.items()), "pointers": pointers}
    return type(name, (Structure,), members)


STRUCTURES: dict[str, type[Structure]] = {}  # by their names in C
for _part in DECLARATIONS.split("typedef struct {")[1:]:
    _body, _, _rest = _part.partition("}")
    _name = _rest.partition(";")[0].strip()
    STRUCTURES[_name] = TYPES[_name] = _structure(_name, _body)

MODES = int(_NUMBERS["SM_MODES"])
OUTPUTS_FIXED = int(_NUMBERS["SM_OUTPUTS_FIXED"])

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
# Types of arrays by the type of a pointer in C. Complex numbers are pairs of doubles, and inputs
# are rows of doubles.
_ARRAYS = {
    "double": (np.dtype(float), np.dtype(complex)),
    "int32_t": (np.dtype(np.int32),),
    "sm_inputs": (INPUTS, np.dtype(float)),
    "sm_element": (ELEMENT,),
    "sm_segment": (SEGMENT,),
}
INPUT_QUANTITIES = ("force", "frequency", "phase")
INPUT_FIELDS = tuple(name + rate for name in INPUT_QUANTITIES for rate in ("", "_rate"))
SCALE_FIELDS = ("limit_scale", "limit_scale_rate")  # of all contacts, not of a mode
