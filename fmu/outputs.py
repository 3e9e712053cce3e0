"""What a component says of its model and state: output names, strained assumptions, an error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.fmu.handle import ComponentOptions
from slipmode.fmu.inputs import Inputs
from slipmode.rom import Model, kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns, phasor
from slipmode.rom.slow.slow_flow import rates, slow_flow
from slipmode.rom.slow.transient import TransientError
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.validity import Finding, mode_frequency_findings, model_findings


def output_names(
    model: Model | ToneModel, named: Inputs, options: ComponentOptions
) -> tuple[str, ...]:
    """Return the names of the outputs of a component, in the order of the core."""
    names = ["time", *(f"{mode}_{part}" for mode in named.mode_names for part in ("re", "im"))]
    names += [f"theta_{mode}" for mode in named.carriers]
    names += ["input_power", "dissipated_power", "dissipated_energy"]
    if options.contact:
        contacts = range(model.reduced.n_contacts)
        names += [f"contact_{i}_{quantity}" for quantity in "xvf" for i in contacts]
        names += [f"x_{dof}" for dof in options.elastic]
    return tuple(names)


def findings_of(model: Model, mode_names: Sequence[str]) -> list[Finding]:
    """Return the assumptions of the method that a model strains."""
    reduced, largest = model.reduced, model.table.amplitude_range
    return [
        *mode_frequency_findings(mode_names, reduced.frequency),
        *model_findings(reduced, model.law, largest, model.combinations, mode_names),
    ]


def transient_error(
    model: Model, force_patterns: ForcePatterns | None, inputs: Floats, outputs: Floats
) -> Floats:
    """Return the estimated error of |a_j| due to transients (modes,) [kg^1/2 m].

    `inputs` is a record (1, width) of `Inputs.modal`, and `outputs` begins with the slow outputs.
    """
    modes, record = slice(0, model.modes), inputs.view(kernel.INPUTS).ravel()
    amplitude = outputs[1:5].view(complex)[np.newaxis, modes]
    record["angle"][0] = outputs[5:7]
    rate = rates(slow_flow(model, force_patterns), record, amplitude)
    scale = record["limit_scale"][0]
    if force_patterns is not None:
        shift = AppliedForces.of(model.reduced, force_patterns).shift
        amplitude = amplitude + shift * phasor(record["force"], record["phase"])[:, modes]
    estimate = TransientError.of(model.reduced, model.law)
    error = estimate.at(rate / scale, record["frequency"][:, modes], amplitude / scale)
    return np.asarray(scale * error[0])
