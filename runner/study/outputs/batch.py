"""A batch of samples on one model: their results, and why some have none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.short_repr import short_repr
from slipmode.runner.scene.scene import Scene
from slipmode.runner.study.outputs.runs import record, run_through
from slipmode.runner.study.outputs.steady import Loads, curves, peaks, steady_states
from slipmode.runner.study.scene_model import Samples, SceneModel


@dataclass(frozen=True, eq=False)
class Batch:
    """Results of some samples.

    Attributes
    ----------
    values : dict of str to (samples, ...) ndarray
        By the names of `Asked.results`; NaN where there are none.
    reason : list of str
        Of samples without results; empty otherwise.
    outside : (samples,) ndarray of bool
        Whether the friction table ends before the sample, so that a larger one would help.
    """

    values: dict[str, Floats]
    reason: list[str]
    outside: Flags

    __repr__ = short_repr

    @classmethod
    def empty(cls, samples: Samples, modes: Sequence[str], count: int) -> Batch:
        """Without results as yet."""
        values = {
            result.name: np.full((count, *result.shape), np.nan)
            for result in samples.asked.results(modes)
        }
        return cls(values, [""] * count, np.zeros(count, dtype=bool))

    def put(self, places: Sequence[int], found: Batch) -> None:
        """Results of some of the samples, in their places."""
        for name, values in found.values.items():
            self.values[name][places] = values
        self.outside[places] = found.outside
        for place, why in zip(places, found.reason, strict=True):
            self.reason[place] = why


def compute(
    samples: Samples,
    modes: Sequence[str],
    shared: SceneModel,
    model: Model,
    read: Sequence[Scene | str],
    numbers: Sequence[int],
) -> Batch:
    """What is asked of some samples, each by itself: one that is refused leaves others alone.

    Parameters
    ----------
    modes : sequence of str
        Of the scene, in the order of the results.
    shared : SceneModel
    model : Model
        One of `shared`.
    read : sequence of Scene or str
        Of the samples, or why there is none.
    numbers : sequence of int
        Of the samples in the study: recordings are named by them.
    """
    asked = samples.asked
    batch = Batch.empty(samples, modes, len(read))
    batch.reason[:] = [each if isinstance(each, str) else "" for each in read]
    places = [k for k, why in enumerate(batch.reason) if not why]
    scenes = [each for each in read if not isinstance(each, str)]
    if scenes and (asked.steady or asked.resonance or asked.curve):
        loads = Loads.of(scenes, shared.excited)
        columns = [modes.index(mode) for mode in shared.excited.modes]
        at = np.ix_(places, columns)
        for name in ("steady", "resonance", "curve"):
            if not getattr(asked, name):
                continue
            solve = {"steady": steady_states, "resonance": peaks, "curve": curves}[name]
            found = solve(asked, shared.excited, model, loads)
            for key, values in found.values.items():
                batch.values[key][places] = _at_rest(key)
                batch.values[key][at] = values
            for k, why, out in zip(places, found.reason, found.outside, strict=True):
                batch.reason[k] = batch.reason[k] or why
                batch.outside[k] |= out
    if asked.runs:
        for k, scene in zip(places, scenes, strict=True):
            if not batch.reason[k]:
                _run(k, scene, modes, shared, model, batch, samples)
    if asked.dofs:
        _displacements(asked.dofs, shared, modes, batch)
    if samples.recordings is not None:
        for k, scene in zip(places, scenes, strict=True):
            if not batch.reason[k]:
                batch.reason[k] = record(scene, samples.recordings, numbers[k])
    for values in batch.values.values():
        values[[bool(why) for why in batch.reason]] = np.nan
    return batch


def _run(
    k: int,
    scene: Scene,
    modes: Sequence[str],
    shared: SceneModel,
    model: Model,
    batch: Batch,
    samples: Samples,
) -> None:
    run = run_through(scene, shared.excited, model, samples.asked.times)
    batch.reason[k], batch.outside[k] = run.reason, run.outside
    columns = [modes.index(mode) for mode in shared.excited.modes]
    for name, values in (("peak", run.peak), ("at", run.at)):
        if name in batch.values:
            batch.values[name][k] = 0.0
            batch.values[name][k, columns] = values


def _displacements(
    dofs: Sequence[int], shared: SceneModel, modes: Sequence[str], batch: Batch
) -> None:
    """Amplitudes of DOFs in the shapes of the modes, beside those of the modes."""
    reduced = shared.excited.reduced
    if max(dofs) >= reduced.n_dofs:
        refused = f"outputs.dofs: must be 0 to {reduced.n_dofs - 1}, got {max(dofs)}"
        batch.reason[:] = [why or refused for why in batch.reason]
        return
    shapes = np.zeros((len(modes), len(dofs)))
    for j, mode in enumerate(shared.excited.modes):
        shapes[modes.index(mode)] = 2.0 * np.abs(reduced.mode_shapes[list(dofs), j])
    for name in list(batch.values):
        if name.endswith("_displacement"):
            amplitude = batch.values[name.removesuffix("_displacement")]
            along = amplitude.ndim - 2  # axes of a curve or of times, after samples and modes
            factor = shapes.reshape(len(modes), *(1,) * along, len(dofs))
            batch.values[name][:] = amplitude[..., np.newaxis] * factor


def _at_rest(name: str) -> float:
    """The result of a mode that is not modelled, for nothing moves it."""
    return np.nan if name.endswith(("_phase", "_frequency")) else 0.0
