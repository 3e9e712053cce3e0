"""The structures of slipmode.h, as ctypes and as columns of arrays.

They take no attribute but their fields and `owned`, which keeps alive what they point to.
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


class Contact(Structure):
    """sm_contact."""

    __slots__ = ("owned",)

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
        ("elastic", c_void_p),
    )


class Elastic(Structure):
    """sm_elastic."""

    __slots__ = ("owned",)

    _fields_ = (
        ("elements", c_int32),
        ("sliders", c_int32),
        ("element", c_void_p),
        ("slider", c_void_p),
        ("reference", c_void_p),
    )


class ModalResponse(Structure):
    """sm_modal_response."""

    __slots__ = ("owned",)

    _fields_ = (
        ("orders_count", c_int32),
        ("orders", c_void_p),
        ("asked", c_int32),
        ("dynamic_stiffness", c_void_p),
        ("marched", c_int32),
        ("drawn", c_void_p),
        ("advance", c_void_p),
        ("periodic", c_void_p),
        ("start", c_void_p),
        ("held", c_void_p),
    )


class Discretisation(Structure):
    """sm_discretisation."""

    _fields_ = (
        ("rates", c_void_p),
        ("steps", c_int32),
        ("lines", c_int32),
        ("orders_count", c_int32),
        ("orders", c_void_p),
        ("tolerance", c_double),
        ("smallest_scale", c_void_p),
        ("max_periods", c_int32),
    )


class TorusPoints(Structure):
    """sm_torus_points."""

    _fields_ = (("count", c_size_t), ("amplitudes", c_void_p), ("near", c_void_p))


class TorusMotion(Structure):
    """sm_torus_motion."""

    _fields_ = (
        ("harmonics", c_void_p),
        ("mean_square", c_void_p),
        ("residual", c_void_p),
        ("marched", c_void_p),
    )


class Table(Structure):
    """sm_table."""

    __slots__ = ("owned",)

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
        ("detuning", c_void_p),
    )


class Combination(Structure):
    """sm_combination."""

    __slots__ = ("owned",)

    _fields_ = (("mode", c_int32), ("n", c_int32), ("m", c_int32))


class SlowFlow(Structure):
    """sm_slow_flow."""

    __slots__ = ("owned",)

    _fields_ = (
        ("paper", c_int32),
        ("natural", c_double * MODES),
        ("damping", c_double * MODES),
        ("table", Table),
        ("carrier", c_double * MODES),
        ("coupling_ratio", (c_double * 2 * 2) * MODES),
        ("off_resonance", (c_double * 2) * MODES),
        ("cross_response", (c_double * 2 * MODES) * MODES),
        ("combination", Combination * COMBINATIONS),
    )


DOUBLES = POINTER(c_double)
CurveRates = CFUNCTYPE(c_int32, c_void_p, DOUBLES, DOUBLES, DOUBLES)  # sm_curve_rates


class Curve(Structure):
    """sm_curve."""

    __slots__ = ("owned",)

    _fields_ = (
        ("unknowns", c_int32),
        ("largest_step", c_double),
        ("rates", CurveRates),
        ("of", c_void_p),
    )


class Branch(Structure):
    """sm_branch."""

    _fields_ = (("before", c_size_t), ("after", c_size_t), ("closed", c_int32))


class Forced(Structure):
    """sm_forced."""

    __slots__ = ("owned",)

    _fields_ = (("flow", c_void_p), ("inputs", c_void_p), ("scale", c_double * MODES))


class Motion(Structure):
    """sm_motion."""

    __slots__ = ("owned",)

    _fields_ = (
        ("wanted", c_int32),
        ("elastic", c_int32),
        ("modes_out", c_void_p),
        ("forces_out", c_void_p),
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

    __slots__ = ("owned",)

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
        ("elastic", c_void_p),
        ("own", c_void_p),
        ("ahead", c_void_p),
        ("flexibility", c_void_p),
    )


class FullSamples(Structure):
    """sm_full_samples."""

    _fields_ = (
        ("count", c_size_t),
        ("every", c_size_t),
        ("displacement", c_void_p),
        ("velocity", c_void_p),
        ("contact", c_void_p),
        ("dissipated", c_void_p),
    )


class HarmonicSum(Structure):
    """sm_harmonic_sum."""

    __slots__ = ("owned",)

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
ELEMENT = np.dtype(
    [
        ("law", np.int32),
        ("column", np.int32, 3),
        ("first_slider", np.int32),
        ("sliders", np.int32),
        ("tangents", np.int32),
        ("friction", float),
        ("preload", float),
        ("tangential_stiffness", float),
        ("normal_stiffness", float),
        ("gap", float),
    ],
    align=True,
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
    "sm_inputs": INPUTS,
    "sm_segment": SEGMENT,
}


class LayoutRow(Structure):
    """sm_layout_row: a field of a structure as it was compiled, or the structure itself."""

    _fields_ = (
        ("structure", c_char_p),
        ("field", c_char_p),
        ("offset", c_size_t),
        ("size", c_size_t),
    )


def layout(structure: type[Structure] | np.dtype[np.void]) -> dict[str, tuple[int, int]]:
    """Offset and size of each field in bytes, in order; of the whole under the name ""."""
    if isinstance(structure, np.dtype):
        fields: Mapping[str, Any] = structure.fields or {}
        of_fields = {name: (fields[name][1], fields[name][0].itemsize) for name in fields}
        return {"": (0, structure.itemsize)} | of_fields
    found = {"": (0, ctypes.sizeof(structure))}
    for name, *_ in structure._fields_:
        field = getattr(structure, name)
        found[name] = (field.offset, field.size)
    return found
