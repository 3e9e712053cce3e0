"""Outputs of a study as pictures and titles show them: modal amplitudes, or those of a DOF."""

from __future__ import annotations

from typing import Any, NamedTuple

from slipmode.rom.slow.units import Shown
from slipmode.runner.study.outputs.asked import MODAL
from slipmode.runner.study.study_file import Study


class ShownOutput(NamedTuple):
    """An output (sample, mode, ...) in its unit, and the words that say of which DOF it is."""

    values: Any
    unit: str
    where: str


def shown_as(study: Study) -> Shown:
    """Return how a study shows amplitudes: of its first DOF if it has any, in scene units."""
    dofs = study.asked.dofs
    return Shown(dofs[0] if dofs else None, study.scene.units, MODAL)


def shown_output(dataset: Any, kind: str, shown: Shown) -> ShownOutput:
    """Return the output of a kind, "steady" or "resonance" for instance, as it is shown."""
    if shown.dof is None:
        return ShownOutput(dataset[kind], shown.modal, "")
    metres = dataset[f"{kind}_displacement"].isel(dof=0)
    values = metres.copy(data=shown.units.of_displacement(metres.values))
    return ShownOutput(values, shown.units.displacement, f" at DOF {shown.dof}")
