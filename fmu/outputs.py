"""Outputs of a component by their names, and what a component warns of."""

from __future__ import annotations

from collections.abc import Sequence

from slipmode.fmu.handle import ComponentOptions, forced_tone
from slipmode.fmu.inputs import AnyModel, Inputs
from slipmode.rom import Model
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import Finding, mode_frequency_findings, model_findings


def checked_findings(
    model: AnyModel, force_patterns: ForcePatterns | None, mode_names: Sequence[str]
) -> list[Finding]:
    """Return the assumptions that a component strains; refuse forces that its table misses."""
    if isinstance(model, ToneModel):
        return forced_tone(model, force_patterns).transient_findings(model.carrier)
    if force_patterns is not None:
        check_force_patterns(model, AppliedForces.of(model.reduced, force_patterns))
    return findings_of(model, mode_names)


def findings_of(model: Model, mode_names: Sequence[str]) -> list[Finding]:
    """Return the assumptions of the method that a model strains."""
    reduced, largest = model.reduced, model.table.amplitude_range
    return [
        *mode_frequency_findings(mode_names, reduced.frequency),
        *model_findings(reduced, model.law, largest, model.combinations, mode_names),
    ]


def output_names(model: AnyModel, named: Inputs, options: ComponentOptions) -> tuple[str, ...]:
    """Return the names of the outputs, in the order of the core."""
    names = ["time", *(f"{mode}_{part}" for mode in named.mode_names for part in ("re", "im"))]
    names += [f"theta_{mode}" for mode in named.carriers]
    names += ["input_power", "dissipated_power", "dissipated_energy"]
    if options.contact:
        contacts = range(model.reduced.n_contacts)
        names += [f"contact_{i}_{quantity}" for quantity in "xvf" for i in contacts]
        names += [f"x_{dof}" for dof in options.elastic]
    return tuple(names)
