"""A batch of samples on one model: their results, and why some samples have none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import short_repr
from slipmode.runner.scene.sections import Scene
from slipmode.runner.study.outputs.runs import record, run_through
from slipmode.runner.study.outputs.steady import Loads, curves, peaks, steady_states
from slipmode.runner.study.scene_model import Samples, SceneModel


@dataclass(frozen=True, eq=False)
class Batch:
    """Results of some samples."""

    values: dict[str, Floats]  # By the names of `Outputs.results`; NaN without a result
    reason: list[str]  # Why a sample has no results; empty if it has
    outside: Flags  # (samples,): Whether a larger friction table is needed

    __repr__ = short_repr

    @classmethod
    def empty(cls, samples: Samples, count: int) -> Batch:
        """Return a batch without results."""
        values = {
            result.name: np.full((count, *result.shape), np.nan)
            for result in samples.outputs.results(samples.modes)
        }
        return cls(values, [""] * count, np.zeros(count, dtype=bool))

    def put(self, places: Sequence[int], found: Batch) -> None:
        """Store the results of some of the samples."""
        for name, values in found.values.items():
            self.values[name][places] = values
        self.outside[places] = found.outside
        for place, why in zip(places, found.reason, strict=True):
            self.reason[place] = why


def compute(
    shared: SceneModel, model: Model, scenes: Sequence[Scene | str], numbers: Sequence[int]
) -> Batch:
    """Return the results of samples; one that is refused does not affect the others.

    Parameters
    ----------
    shared : SceneModel
    model : Model
        A model of `shared`.
    scenes : sequence of Scene or str
        The scene of each sample, or why it is refused.
    numbers : sequence of int
        The numbers of the samples in the study; recordings have them in their names.
    """
    outputs, modes = shared.samples.outputs, shared.samples.modes
    batch = Batch.empty(shared.samples, len(scenes))
    batch.reason[:] = [each if isinstance(each, str) else "" for each in scenes]
    read = {k: each for k, each in enumerate(scenes) if not isinstance(each, str)}
    places = list(read)
    columns = [modes.index(mode) for mode in shared.excited.modes]
    if read and (outputs.steady or outputs.resonance or outputs.curve):
        loads = Loads.of(list(read.values()), shared.excited)
        for kind, solve in (("steady", steady_states), ("resonance", peaks), ("curve", curves)):
            if not getattr(outputs, kind):
                continue
            found = solve(outputs, model, loads)
            for name, values in found.values.items():
                # a mode without a motion is not in the model
                at_rest = np.nan if name.endswith(("_phase", "_frequency")) else 0.0
                batch.values[name][places] = at_rest
                batch.values[name][np.ix_(places, columns)] = values
            for k, why, out in zip(places, found.reason, found.outside, strict=True):
                batch.reason[k] = batch.reason[k] or why
                batch.outside[k] |= out
    for k, scene in read.items():
        if not outputs.runs or batch.reason[k]:
            continue
        run = run_through(scene, shared.excited, model, outputs.times)
        batch.reason[k], batch.outside[k] = run.reason, run.outside
        for name, values in (("peak", run.peak), ("at", run.at)):
            if name in batch.values:
                batch.values[name][k] = 0.0
                batch.values[name][k, columns] = values
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
