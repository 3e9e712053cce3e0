"""The structures of slipmode.h, as ctypes and as columns of arrays.

Their fields are declared in the order of the header.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_double, c_int32, c_size_t, c_void_p
from typing import Any

import numpy as np

MODES = 2
COMBINATIONS = 8
FORCED_CELLS = 1024


_TYPES = {
    **{"int32": c_int32, "size_t": c_size_t, "double": c_double},
    **{"pointer": c_void_p, "text": c_char_p},
}


def fields(declaration: str) -> list[tuple[str, Any]]:
    """Return names and ctypes of fields that are declared as "double a b[2]; int32 c", as in C."""
    found = []
    for row in declaration.split(";"):
        kind, *declared = row.split()
        for name, *sizes in (field.replace("]", "").split("[") for field in declared):
            array: Any = _TYPES[kind]
            for size in reversed(sizes):
                array *= int(size)
            found.append((name, array))
    return found


class Owning(Structure):
    """A structure that points to arrays: `owned` keeps them alive. It takes no other attribute."""

    __slots__ = ("owned",)


class Contact(Owning):
    """sm_contact."""

    __slots__ = ()

    _fields_ = fields(
        "int32 contacts modes law; double alpha; pointer limit stiffness damping coupling "
        "mass response elastic"
    )


class Elastic(Owning):
    """sm_elastic."""

    __slots__ = ()

    _fields_ = fields("int32 elements sliders; pointer element slider reference")


class ModalResponse(Owning):
    """sm_modal_response."""

    __slots__ = ()

    _fields_ = fields(
        "int32 orders_count; pointer orders; int32 asked; pointer dynamic_stiffness; int32 "
        "marched; pointer drawn advance periodic start held"
    )


class Discretisation(Structure):
    """sm_discretisation."""

    _fields_ = fields(
        "pointer rates; int32 steps lines orders_count; pointer orders; double tolerance; "
        "pointer smallest_scale; int32 max_periods"
    )


class TorusPoints(Structure):
    """sm_torus_points."""

    _fields_ = fields("size_t count; pointer amplitudes near")


class TorusMotion(Structure):
    """sm_torus_motion."""

    _fields_ = fields("pointer harmonics mean_square residual marched")


class Table(Owning):
    """sm_table."""

    __slots__ = ()

    _fields_ = fields(
        "int32 modes combinations power count_a count_b; pointer node_a node_b values "
        "rate_correction detuning"
    )


class Combination(Owning):
    """sm_combination."""

    __slots__ = ()

    _fields_ = fields("int32 mode n m")


class SlowFlow(Owning):
    """sm_slow_flow."""

    __slots__ = ()

    _fields_ = (
        *fields("int32 paper; double natural[2] damping[2]"),
        ("table", Table),
        *fields("double carrier[2] coupling_ratio[2][2][2] off_resonance[2][2]"),
        *fields("double cross_response[2][2][2]"),
        ("combination", Combination * COMBINATIONS),
    )


DOUBLES = POINTER(c_double)
CurveRates = CFUNCTYPE(c_int32, c_void_p, DOUBLES, DOUBLES, DOUBLES)  # sm_curve_rates


class Curve(Owning):
    """sm_curve."""

    __slots__ = ()

    _fields_ = (
        *fields("int32 unknowns; double largest_step"),
        ("rates", CurveRates),
        *fields("pointer of"),
    )


class Branch(Structure):
    """sm_branch."""

    _fields_ = fields("size_t before after; int32 closed")


class Forced(Owning):
    """sm_forced."""

    __slots__ = ()

    _fields_ = fields("pointer flow inputs; double scale[2]")


class Motion(Owning):
    """sm_motion."""

    __slots__ = ()

    _fields_ = fields(
        "int32 wanted elastic; pointer modes_out forces_out contacts_out; int32 orders_count; "
        "pointer orders reaction response; int32 steps_per_period; double memory_periods"
    )


class Full(Owning):
    """sm_full."""

    __slots__ = ()

    _fields_ = fields(
        "int32 coordinates contacts modes outputs law diagonal; double alpha step; pointer "
        "limit stiffness damping directions patterns output inverse resistance elastic own "
        "ahead flexibility"
    )


class FullSamples(Structure):
    """sm_full_samples."""

    _fields_ = fields("size_t count every; pointer displacement velocity contact dissipated")


class ContactSamples(Structure):
    """sm_contact_samples."""

    _fields_ = fields("size_t count; pointer times displacement velocity force")


class TrajectorySteps(Structure):
    """sm_trajectory_steps."""

    _fields_ = fields("size_t count; pointer inputs duration start end")


class Trace(Structure):
    """sm_trace."""

    _fields_ = fields("size_t capacity count; pointer outputs; size_t done; double elapsed")


class HarmonicSum(Owning):
    """sm_harmonic_sum."""

    __slots__ = ()

    _fields_ = fields(
        "int32 modes orders_count; pointer orders; size_t signals; pointer shape coefficient"
    )


# sm_inputs and sm_segment are arrays of doubles: columns of a float64 array.
INPUT_QUANTITIES = ("force", "frequency", "phase")
INPUT_FIELDS = tuple(name + rate for name in INPUT_QUANTITIES for rate in ("", "_rate"))
ENDS = ("start", "end")  # of a segment
SCALE_FIELDS = ("limit_scale", "limit_scale_rate")  # of all contacts, not of a mode
INPUTS = np.dtype(
    [
        *((name, float, MODES) for name in INPUT_FIELDS),
        *((name, float) for name in SCALE_FIELDS),
        ("angle", float, MODES),
    ]
)
ELEMENT = np.dtype(
    [
        *(("law", np.int32), ("column", np.int32, 3), ("first_slider", np.int32)),
        *(("sliders", np.int32), ("tangents", np.int32), ("friction", float), ("preload", float)),
        *(("tangential_stiffness", float), ("normal_stiffness", float), ("gap", float)),
    ],
    align=True,
)
SEGMENT = np.dtype(
    [
        *((name, float) for name in ("start", "duration")),
        *((f"{name}_{end}", complex, MODES) for name in ("amplitude", "rate") for end in ENDS),
        *((name, float, MODES) for name in ("angle", "frequency", "frequency_rate")),
        *((f"reaction_{end}", np.uintp) for end in ENDS),
    ]
)

STRUCTURES: dict[str, type[Structure] | np.dtype[np.void]] = {
    "sm_contact": Contact,
    "sm_elastic": Elastic,
    "sm_element": ELEMENT,
    "sm_modal_response": ModalResponse,
    "sm_discretisation": Discretisation,
    "sm_torus_points": TorusPoints,
    "sm_torus_motion": TorusMotion,
    "sm_table": Table,
    "sm_combination": Combination,
    "sm_slow_flow": SlowFlow,
    "sm_curve": Curve,
    "sm_branch": Branch,
    "sm_forced": Forced,
    "sm_motion": Motion,
    "sm_full": Full,
    "sm_full_samples": FullSamples,
    "sm_harmonic_sum": HarmonicSum,
    "sm_contact_samples": ContactSamples,
    "sm_trajectory_steps": TrajectorySteps,
    "sm_trace": Trace,
    "sm_inputs": INPUTS,
    "sm_segment": SEGMENT,
}


class LayoutRow(Structure):
    """sm_layout_row: a field of a structure as it was compiled, or the structure itself."""

    _fields_ = fields("text structure field; size_t offset size")


def layout(structure: type[Structure] | np.dtype[np.void]) -> dict[str, tuple[int, int]]:
    """Return offset and size of each field in bytes, in order; of the whole under the name ""."""
    if isinstance(structure, np.dtype):
        fields: Mapping[str, Any] = structure.fields or {}
        of_fields = {name: (fields[name][1], fields[name][0].itemsize) for name in fields}
        return {"": (0, structure.itemsize)} | of_fields
    found = {"": (0, ctypes.sizeof(structure))}
    for name, *_ in structure._fields_:
        field = getattr(structure, name)
        found[name] = (field.offset, field.size)
    return found
