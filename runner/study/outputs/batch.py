"""A batch of samples on one model: their results, and why some samples have none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom import Model
from slipmode.runner.scene.sections import Scene
from slipmode.runner.study.outputs.outputs import Batch
from slipmode.runner.study.outputs.runs import record, run_through
from slipmode.runner.study.outputs.steady import Loads, curves, peaks, steady_states
from slipmode.runner.study.scene_model import SceneModel


def compute(
    shared: SceneModel, model: Model, scenes: Sequence[Scene | str], numbers: Sequence[int]
) -> Batch:
    """Return the results of samples on a model; one that is refused does not affect the others.

    `scenes` has the scene of each sample, or why it is refused. `numbers` are the numbers of the
    samples in the study; recordings have them in their names.
    """
    outputs, modes = shared.samples.outputs, shared.samples.modes
    batch = Batch.empty(outputs, modes, len(scenes))
    batch.reason[:] = [each if isinstance(each, str) else "" for each in scenes]
    read = {k: each for k, each in enumerate(scenes) if not isinstance(each, str)}
    places = list(read)
    columns = [modes.index(mode) for mode in shared.excited.modes]
    if read and (outputs.steady or outputs.resonance or outputs.curve):
        loads = Loads.of(list(read.values()), shared.excited)
        for kind, solve in (("steady", steady_states), ("resonance", peaks), ("curve", curves)):
            if getattr(outputs, kind):
                batch.add(places, columns, solve(outputs, model, loads))
    for k, scene in read.items():
        if outputs.runs and not batch.reason[k]:
            batch.add([k], columns, run_through(scene, shared.excited, model, outputs.times))
    if outputs.dofs:
        _add_displacements(batch, shared)
    if shared.samples.recordings is not None:
        for k, scene in read.items():
            if not batch.reason[k]:
                batch.reason[k] = record(scene, shared.samples.recordings, numbers[k])
    for values in batch.values.values():
        values[[bool(why) for why in batch.reason]] = np.nan
    return batch


def _add_displacements(batch: Batch, shared: SceneModel) -> None:
    """Add the amplitudes of DOFs in the shapes of the modes."""
    reduced, dofs = shared.excited.reduced, list(shared.samples.outputs.dofs)
    modes = shared.samples.modes
    if max(dofs) >= reduced.n_dofs:
        refused = f"outputs.dofs: must be 0 to {reduced.n_dofs - 1}, got {max(dofs)}"
        batch.reason[:] = [why or refused for why in batch.reason]
        return
    shapes = np.zeros((len(modes), len(dofs)))
    for j, mode in enumerate(shared.excited.modes):
        shapes[modes.index(mode)] = 2.0 * np.abs(reduced.mode_shapes[dofs, j])
    for name, values in batch.values.items():
        if name.endswith("_displacement"):
            amplitude = batch.values[name.removesuffix("_displacement")]
            between = amplitude.ndim - 2  # axes of a curve or of times, after samples and modes
            factor = shapes.reshape(len(modes), *(1,) * between, len(dofs))
            values[:] = amplitude[..., np.newaxis] * factor
