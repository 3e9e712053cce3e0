"""The files of resources/: what fmu/src/resources/model.c reads, as .npy arrays."""

from __future__ import annotations

import hashlib
import io
import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipmode.fmu.handle import MEMORY_PERIODS, STEPS_PER_PERIOD
from slipmode.fmu.inputs import force_factors
from slipmode.fmu.variables.listing import PARAMETERS, states
from slipmode.fmu.variables.variable import Kind, Variable
from slipmode.rom import Model, kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.laws.elements import Elements
from slipmode.rom.laws.friction import limits
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.slow.nonresonant.response_surface import (
    forces_out,
    no_response,
    response_surface,
)
from slipmode.rom.slow.slow_flow import slow_flow
from slipmode.rom.validity import carrier_range

FORMAT = 9  # FMU_FORMAT in fmu/src/resources/model.h
IDENTITY = "model.txt"
_ELEMENT_WIDTH = 12  # doubles of an element: its law, three columns and the other fields


def resource_files(
    model: Model,
    force_patterns: ForcePatterns | None,
    contact: bool,
    elastic: Sequence[int],
    variables: Sequence[Variable],
) -> dict[str, bytes]:
    """Content of each file by name; token.txt holds the hash of the others.

    The file IDENTITY is for importers in Python; the FMU does not read it.
    """
    flow = slow_flow(model, force_patterns)
    constants = _constants(model, force_patterns, flow, variables)
    arrays = _arrays(model, force_patterns, constants, contact, elastic, variables)
    files = {f"{name}.npy": _npy(array) for name, array in arrays.items()}
    files["names.txt"] = "".join(f"{v.name}\n" for v in variables).encode()
    checksums = np.array([zlib.crc32(content) for content in files.values()], dtype="<u4")
    files["checksums.npy"] = _npy(checksums.view("<i4"))
    files[IDENTITY] = _identity(model, force_patterns, flow).encode()
    digest = hashlib.sha256()
    for name, content in files.items():
        digest.update(f"{name} {len(content)} ".encode() + content)
    files["token.txt"] = digest.hexdigest().encode()
    return files


def identity(model: Model, force_patterns: ForcePatterns | None) -> str:
    """Hash of what a model and the directions of its forces make of any inputs."""
    return _identity(model, force_patterns, slow_flow(model, force_patterns))


def _identity(model: Model, force_patterns: ForcePatterns | None, flow: kernel.SlowFlow) -> str:
    # whatever is kept of the contact motion, amplitudes do not depend on it
    digest = hashlib.sha256(replace(model, harmonics=None).hash.encode())
    digest.update(
        force_factors(model, force_patterns).tobytes()
        + bytes(flow.off_resonance)
        + bytes(flow.cross_response)
    )
    return digest.hexdigest()


def _npy(array: np.ndarray) -> bytes:
    target = io.BytesIO()
    np.lib.format.write_array(target, np.ascontiguousarray(array), version=(1, 0))
    return target.getvalue()


def _arrays(
    model: Model,
    force_patterns: ForcePatterns | None,
    constants: np.ndarray,
    contact: bool,
    elastic: Sequence[int],
    variables: Sequence[Variable],
) -> dict[str, np.ndarray]:
    """The arrays in the order of checksums.npy, which is that of fmu/src/resources/model.c."""
    reduced, table = model.reduced, model.table
    chosen = list(elastic)
    surface = response_surface(model, chosen) if contact else no_response(model)
    contacts = _contacts(model)
    nodes = (table.node_a.size, table.node_b.size, len(surface.orders))
    layout = (
        *(FORMAT, model.modes, reduced.n_contacts, len(chosen)),
        contact_problem(reduced, model.law).law,
        *(int(reduced.formulation == "paper"), len(model.combinations), 1),
        *(table.node_a.size, table.node_b.size, int(table.rate_correction is not None)),
        int(table.detuning is not None),
        int(contacts["contact_mass"].size > 0),
        *(len(contacts["contact_elements"]), len(contacts["contact_sliders"])),
        *(len(surface.orders), STEPS_PER_PERIOD, len(variables)),
    )
    combinations = [(term.mode, term.n, term.m) for term in model.combinations]
    nothing = np.empty((0, 0, 4, 0))
    doubles = {
        "node_a": table.node_a,
        "node_b": table.node_b,
        "table": table.values,
        "rate_correction": nothing if table.rate_correction is None else table.rate_correction,
        "detuning": nothing if table.detuning is None else table.detuning,
        **contacts,
        "elastic_modes": surface.modes_out.view(float).reshape(len(chosen), model.modes, 2),
        "elastic_forces": forces_out(model, force_patterns, chosen)
        .view(float)
        .reshape(len(chosen), model.modes, 2),
        "elastic_contacts": reduced.contact_shapes[chosen],
    }
    response = {
        "contact_reaction": surface.reaction.view(float).reshape(*nodes, 2 * reduced.n_contacts),
        "elastic_response": surface.elastic.view(float).reshape(*nodes, 2 * len(chosen)),
    }
    return {
        "layout": np.array(layout, dtype="<i4"),
        "constants": constants.astype("<f8"),
        "inputs": _inputs(variables).astype("<f8"),
        "combinations": np.array(combinations, dtype="<i4").reshape(-1, 3),
        **{name: np.asarray(array, dtype="<f8") for name, array in doubles.items()},
        "orders": surface.orders.astype("<i4"),
        **{name: np.asarray(array, dtype="<f8") for name, array in response.items()},
        "variables": np.array([(v.type, v.kind, v.slot) for v in variables], dtype="<i4"),
    }


def _contacts(model: Model) -> dict[str, Floats]:
    """The contact problem; what its law has not is empty."""
    reduced, elements = model.reduced, model.reduced.contacts
    none, n = np.empty((0, 0)), reduced.n_contacts
    has_mass = reduced.formulation == "consistent" and elements is None
    coupling = np.ascontiguousarray(reduced.coupling).view(float)
    return {
        "contact_limit": limits(model.law, n) if elements is None else np.empty(0),
        "contact_stiffness": reduced.stiffness,
        "contact_damping": reduced.damping if elements is None else none,
        "contact_mass": reduced.mass if has_mass else none,
        "contact_coupling": coupling.reshape(model.modes, n, 2),
        "contact_elements": np.empty((0, _ELEMENT_WIDTH)) if elements is None else _rows(elements),
        "contact_sliders": np.empty((0, 2)) if elements is None else elements.slider,
        "contact_reference": np.empty(0) if elements is None else elements.reference,
    }


def _rows(elements: Elements) -> Floats:
    """sm_element in doubles, one a row."""
    names = kernel.ELEMENT.names or ()
    return np.column_stack([elements.element[name].astype(float) for name in names])


def _constants(
    model: Model,
    force_patterns: ForcePatterns | None,
    flow: kernel.SlowFlow,
    variables: Sequence[Variable],
) -> np.ndarray:
    """The struct `constants` of fmu/src/resources/model.c."""
    parameters = np.zeros(PARAMETERS)
    amplitude = np.zeros(2 * kernel.MODES)
    for variable in variables:
        if variable.start is not None and variable.kind is Kind.PARAMETER:
            parameters[variable.slot] = variable.start
        if variable.start is not None and variable.kind is Kind.START:
            amplitude[variable.slot - 1] = variable.start
    nominal = np.zeros(3 * kernel.MODES + 1)
    for k, state in enumerate(states(variables)):
        nominal[k] = state.nominal
    return np.concatenate(
        [
            [contact_problem(model.reduced, model.law).alpha, MEMORY_PERIODS],
            np.array(flow.natural),
            np.array(flow.carrier),
            np.array(flow.coupling_ratio).ravel(),
            np.array(flow.off_resonance).ravel(),
            np.array(flow.cross_response).ravel(),
            force_factors(model, force_patterns),
            *(parameters, nominal, amplitude, carrier_range(1.0)),
        ]
    )


def _inputs(variables: Sequence[Variable]) -> np.ndarray:
    """sm_inputs at the start."""
    inputs = kernel.inputs(1).view(float).ravel()
    for variable in variables:
        if variable.kind is Kind.INPUT and variable.start is not None:
            inputs[variable.slot] = variable.start
    return np.asarray(inputs)
