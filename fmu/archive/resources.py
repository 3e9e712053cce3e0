"""The files of resources/ that fmu/src/resources/model.c reads, as .npy arrays."""

from __future__ import annotations

import hashlib
import io
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from slipmode.fmu.handle import (
    MEMORY_PERIODS,
    STEPS_PER_PERIOD,
    ComponentOptions,
    forced_tone,
)
from slipmode.fmu.inputs import AnyModel, carried_frequencies, force_factors, relative_range
from slipmode.fmu.variables.listing import states
from slipmode.fmu.variables.variable import Kind, Variable
from slipmode.rom import Model, kernel, sample_of
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.laws.friction import limits
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.slow.nonresonant.response_surface import (
    forces_out,
    no_response,
    response_surface,
)
from slipmode.rom.slow.slow_flow import slow_flow
from slipmode.rom.table.local.tone_model import ToneModel

FORMAT = 15  # FMU_FORMAT in fmu/src/resources/model.h
IDENTITY = "model.txt"

# The struct `fmu_layout` of fmu/src/resources/model.h, without the format.
_LAYOUT = (
    *("modes", "contacts", "elastic", "law", "paper", "combinations", "power", "count_a"),
    *("count_b", "corrected", "detuned", "inertia", "elements", "sliders", "orders"),
    *("steps_per_period", "samples", "variables", "kinds", "nodes", "shares"),
    *(f"{count}_{letter}" for count in ("slow", "fast", "modes") for letter in "ab"),
)
_ROW = 3 + len(kernel.ELEMENT.names or ())  # doubles of an sm_element, with its arrays
# Arrays of models with a friction table, in their order, with their shapes in other models.
_TABLE_ARRAYS = {
    "combinations": (0, 3),
    "node_a": (0,),
    "node_b": (0,),
    "table": (0, 0, 4, 0),
    "rate_correction": (0, 0, 4, 0),
    "detuning": (0, 0, 4, 0),
    "contact_limit": (0,),
    "contact_stiffness": (0, 0),
    "contact_damping": (0, 0),
    "contact_mass": (0, 0),
    "contact_coupling": (0, 0, 2),
    "contact_elements": (0, _ROW),
    "contact_sliders": (0, 2),
    "contact_reference": (0,),
    "elastic_modes": (0, 0, 2),
    "elastic_forces": (0, 0, 2),
    "elastic_contacts": (0, 0),
    "orders": (0, 2),
    "contact_reaction": (0, 0, 0, 0),
    "elastic_response": (0, 0, 0, 0),
    "samples": (0, 0),
}
_INTEGERS = ("combinations", "orders")


def resource_files(
    model: AnyModel,
    force_patterns: ForcePatterns | None,
    options: ComponentOptions,
    variables: Sequence[Variable],
) -> dict[str, bytes]:
    """Return the content of each file by name; token.txt holds the hash of the others.

    The file IDENTITY is for importers in Python; the FMU does not read it.
    """
    arrays = model_arrays(model, force_patterns, options, variables)
    if isinstance(model, ToneModel):
        own = hashlib.sha256(arrays["tone"].tobytes()).hexdigest()
    else:
        own = identity(model, force_patterns)
    return packed_files(arrays, variables, own)


def packed_files(
    arrays: Mapping[str, np.ndarray], variables: Sequence[Variable], identity_hash: str
) -> dict[str, bytes]:
    """Return the files of arrays, as `resource_files` does."""
    files = {f"{name}.npy": _npy(array) for name, array in arrays.items()}
    files["names.txt"] = "".join(f"{v.name}\n" for v in variables).encode()
    checksums = np.array([zlib.crc32(content) for content in files.values()], dtype=np.uint32)
    files["checksums.npy"] = _npy(checksums.view(np.int32))
    files[IDENTITY] = identity_hash.encode()
    digest = hashlib.sha256()
    for name, content in files.items():
        digest.update(f"{name} {len(content)} ".encode() + content)
    files["token.txt"] = digest.hexdigest().encode()
    return files


def identity(model: Model, force_patterns: ForcePatterns | None) -> str:
    """Return the hash of all data on which amplitudes depend: model and force directions."""
    flow = slow_flow(model, force_patterns)
    # amplitudes do not depend on the harmonics that are kept of the contact motion
    digest = hashlib.sha256(replace(model, harmonics=None, dof_response=None).hash.encode())
    digest.update(force_factors(model, force_patterns).tobytes())
    digest.update(bytes(flow.off_resonance) + bytes(flow.cross_response))
    digest.update(bytes(flow.other_modes))
    return digest.hexdigest()


def _npy(array: np.ndarray) -> bytes:
    """Return a little-endian .npy file of 32-bit integers or doubles."""
    target, kind = io.BytesIO(), "<i4" if array.dtype.kind == "i" else "<f8"
    np.lib.format.write_array(target, np.ascontiguousarray(array, dtype=kind), version=(1, 0))
    return target.getvalue()


def model_arrays(
    model: AnyModel,
    force_patterns: ForcePatterns | None,
    options: ComponentOptions,
    variables: Sequence[Variable],
) -> dict[str, np.ndarray]:
    """Return the arrays in the order of checksums.npy and fmu/src/resources/model.c."""
    layout = {
        "modes": model.modes,
        "contacts": model.reduced.n_contacts,
        "elastic": len(options.elastic),
        "variables": len(variables),
    }
    if isinstance(model, ToneModel):
        counts, arrays = _tone_arrays(model, force_patterns, options)
    else:
        counts, arrays = _table_arrays(model, force_patterns, options)
    layout |= counts
    return {
        "layout": np.array([FORMAT, *(layout.get(name, 0) for name in _LAYOUT)], dtype=np.int32),
        "constants": _constants(model, force_patterns, variables),
        "inputs": _with_starts(kernel.inputs(1).view(float).ravel(), variables, Kind.INPUT),
        **arrays,
        "variables": np.array([(v.type, v.kind, v.slot) for v in variables], dtype=np.int32),
    }


def _tone_arrays(
    model: ToneModel, force_patterns: ForcePatterns | None, options: ComponentOptions
) -> tuple[dict[str, int], dict[str, np.ndarray]]:
    """Return counts and arrays of modes that share a tone."""
    tone = forced_tone(model, force_patterns).core(model.carrier, options.elastic, True)
    counts = {name: getattr(tone, name) for name in ("kinds", "nodes", "shares")}
    for letter, carrier in zip("ab", tone.owned["carrier"], strict=False):
        counts |= {f"slow_{letter}": carrier.slow.count, f"fast_{letter}": carrier.fast.count}
        counts[f"modes_{letter}"] = carrier.amplitudes
    empty = {
        name: np.empty(shape, dtype=np.int32 if name in _INTEGERS else float)
        for name, shape in _TABLE_ARRAYS.items()
    }
    return counts, {**empty, "tone": np.concatenate(list(_numbers(tone)))}


def _numbers(part: kernel.Structure) -> Iterator[Floats]:
    """Yield the doubles of a structure and of its arrays, in the order of its fields."""
    for name, *_ in part._fields_:
        value = part.owned.get(name, getattr(part, name))
        if isinstance(value, kernel.Structure | list):
            for each in value if isinstance(value, list) else [value]:
                yield from _numbers(each)
        elif isinstance(value, np.ndarray | float):
            yield np.ravel(value)


def _table_arrays(
    model: Model, force_patterns: ForcePatterns | None, options: ComponentOptions
) -> tuple[dict[str, int], dict[str, np.ndarray]]:
    """Return counts and arrays of a model with a friction table."""
    reduced, table, chosen = model.reduced, model.table, list(options.elastic)
    surface = response_surface(model, chosen) if options.contact else no_response(model)
    contacts, nodes = _contacts(model), (table.node_a.size, table.node_b.size)
    counts = {
        "law": contact_problem(reduced, model.law).law,
        "paper": reduced.formulation == "paper",
        "combinations": len(model.combinations),
        "power": 1,
        "count_a": nodes[0],
        "count_b": nodes[1],
        "corrected": table.rate_correction is not None,
        "detuned": table.detuning is not None,
        "inertia": contacts["contact_mass"].size > 0,
        "elements": len(contacts["contact_elements"]),
        "sliders": len(contacts["contact_sliders"]),
        "orders": len(surface.orders),
        "steps_per_period": STEPS_PER_PERIOD,
        "samples": 0 if model.samples is None else len(model.samples),
    }
    combinations = [(term.mode, term.n, term.m) for term in model.combinations]
    nothing = np.empty((0, 0, 4, 0))
    by_modes = (len(chosen), model.modes, 2)
    by_nodes = (*nodes, len(surface.orders))
    return counts, {
        "combinations": np.array(combinations, dtype=np.int32).reshape(-1, 3),
        "node_a": table.node_a,
        "node_b": table.node_b,
        "table": table.values,
        "rate_correction": nothing if table.rate_correction is None else table.rate_correction,
        "detuning": nothing if table.detuning is None else table.detuning,
        **contacts,
        "elastic_modes": surface.modes_out.view(float).reshape(by_modes),
        "elastic_forces": forces_out(model, force_patterns, chosen).view(float).reshape(by_modes),
        "elastic_contacts": reduced.contact_shapes[chosen],
        "orders": surface.orders.astype(np.int32),
        "contact_reaction": surface.reaction.view(float).reshape(
            *by_nodes, 2 * reduced.n_contacts
        ),
        "elastic_response": surface.elastic.view(float).reshape(*by_nodes, 2 * len(chosen)),
        "samples": _samples(model, force_patterns, chosen),
        "tone": np.empty(0),
    }


def _samples(model: Model, force_patterns: ForcePatterns | None, elastic: Sequence[int]) -> Floats:
    """Return what differs between the samples, a row each, as fmu_set_parameters reads it."""
    rows = []
    for sample in range(1, 1 + (0 if model.samples is None else len(model.samples))):
        own = sample_of(model, sample)
        flow, table = slow_flow(own, force_patterns), own.table
        parts: list[Any] = [flow.natural, flow.damping, flow.cross_response, flow.other_modes]
        parts += [table.values, table.rate_correction]
        parts.append(forces_out(own, force_patterns, elastic).view(float))
        rows.append(np.concatenate([np.ravel(part) for part in parts]))
    return np.array(rows) if rows else np.empty((0, 0))


def _contacts(model: Model) -> dict[str, Floats]:
    """Return the contact problem; arrays that its law does not need are empty."""
    reduced, elements, n = model.reduced, model.reduced.contacts, model.reduced.n_contacts
    names = kernel.ELEMENT.names or ()
    coupling = np.ascontiguousarray(reduced.coupling).view(float)
    found = {
        "contact_limit": np.empty(0),
        "contact_stiffness": reduced.stiffness,
        "contact_damping": np.empty((0, 0)),
        "contact_mass": np.empty((0, 0)),
        "contact_coupling": coupling.reshape(model.modes, n, 2),
        "contact_elements": np.empty((0, _ROW)),
        "contact_sliders": np.empty((0, 2)),
        "contact_reference": np.empty(0),
    }
    if elements is None:
        found["contact_limit"] = limits(model.law, n)
        found["contact_damping"] = reduced.damping
        if reduced.formulation == "consistent":
            found["contact_mass"] = reduced.mass
    else:
        rows = [elements.element[name].astype(float) for name in names]  # sm_element in doubles
        found["contact_elements"] = np.column_stack(rows)
        found["contact_sliders"] = elements.slider
        found["contact_reference"] = elements.reference
    return found


def _constants(
    model: AnyModel, force_patterns: ForcePatterns | None, variables: Sequence[Variable]
) -> Floats:
    """Return the struct `fmu_constants` of fmu/src/resources/model.h."""
    alpha, nominal = 0.0, np.zeros(3 * kernel.MODES + 1)
    if isinstance(model, ToneModel):
        flow = kernel.SlowFlow()
        flow.natural[: model.reduced.tones] = model.carrier.tolist()
    else:
        flow = slow_flow(model, force_patterns)
        alpha = contact_problem(model.reduced, model.law).alpha
    for k, state in enumerate(states(variables)):
        nominal[k] = state.nominal
    parts = (
        [alpha, MEMORY_PERIODS],
        flow.natural,
        flow.spin,
        flow.carrier,
        flow.coupling_ratio,
        flow.off_resonance,
        flow.cross_response,
        flow.other_modes,
        force_factors(model, force_patterns),
        _with_starts(np.zeros(kernel.MODES + 3), variables, Kind.PARAMETER),
        nominal,
        _with_starts(np.zeros(1 + 2 * kernel.MODES), variables, Kind.START)[1:],
        np.resize(carried_frequencies(model), kernel.MODES),
        relative_range(model),
        [flow.ratio],
        flow.hardening,
    )
    return np.concatenate([np.array(part).ravel() for part in parts])


def _with_starts(values: Floats, variables: Sequence[Variable], kind: Kind) -> Floats:
    """Set the start values of variables of one kind, by slot."""
    for variable in variables:
        if variable.kind is kind and variable.start is not None:
            values[variable.slot] = variable.start
    return values
