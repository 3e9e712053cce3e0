"""Answers through slow time: peaks, amplitudes at given times, recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from slipmode.fmu import StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.plan.amplitude_range import Excited
from slipmode.runner.plan.plan import start_amplitudes
from slipmode.runner.plan.settling import shortened
from slipmode.runner.run import run
from slipmode.runner.scene.scene import Scene
from slipmode.runner.scene.schedule import Schedule, is_rate, make_schedule, rate_of

_INSIDE = 0.99  # of a table: amplitudes that a run may start from
_NEAR = 0.9  # the same: a run that creeps along its edge finds no step that stays inside


@dataclass(frozen=True, eq=False)
class Run:
    """|a| (modes,), the largest and at times (modes, times); why there are none, see `Batch`."""

    peak: Floats
    at: Floats
    reason: str
    outside: bool = False

    __repr__ = short_repr


def run_through(scene: Scene, excited: Excited, model: Model, times: Sequence[float]) -> Run:
    """A scene on a model that may be of others too."""
    modes = excited.modes
    natural = dict(zip(modes, excited.reduced.frequency.tolist(), strict=True))
    schedule = make_schedule(scene, natural)
    if scene.model.formulation == "consistent":
        excited = replace(excited, amplitude=start_amplitudes(excited, schedule))
    nothing = np.full(len(modes), np.nan), np.full((len(modes), len(times)), np.nan)
    if times and max(times) > scene.run.duration:
        refused = f"outputs.times: run.duration is {scene.run.duration:g}"
        return Run(*nothing, refused)
    scale = 1.0 if scene.limit_scale is None else scene.limit_scale.value(0.0)
    if np.any(np.abs(excited.amplitude) > _INSIDE * scale * model.table.amplitude_range):
        return Run(*nothing, "initial: outside the friction table", outside=True)
    rows = [np.append(0.0, np.array([excited.amplitude]).view(float))[np.newaxis]]
    width = rows[0].shape[1]
    try:
        component = excited.component(model, scene.run.tolerance)
        names = component.input_names
        steps = (
            _until(schedule, names, times) if times else shortened(schedule, model, modes, names)
        )
        rows += [outputs[:, :width].copy() for outputs in component.trace(*steps)]
    except StoppedError as stop:
        reached = np.abs(_amplitude(np.concatenate([*rows, stop.outputs[:, :width]])))
        least = 1.0 if scene.limit_scale is None else scene.limit_scale.range(0.0, stop.time)[0]
        near = bool(np.any(reached > _NEAR * least * model.table.amplitude_range))
        return Run(*nothing, str(stop), stop.left_table or near)
    except SlipmodeError as refusal:
        return Run(*nothing, str(refusal))
    traced = np.concatenate(rows)
    size = np.abs(_amplitude(traced))
    at = [np.argmin(np.abs(traced[:, 0] - t)) for t in times]
    return Run(size.max(axis=0), size[at].T, "")


def record(scene: Scene, folder: Path, number: int) -> str:
    """Record the run of a sample; why there is no recording, or nothing."""
    named = replace(scene, name=f"sample-{number:06d}")
    try:
        run(named, folder)
    except SlipmodeError as refusal:
        return str(refusal)
    return ""


def _amplitude(traced: Floats) -> Complexes:
    """Of rows of outputs, (rows, modes)."""
    return np.asarray(traced[:, 1::2] + 1j * traced[:, 2::2])


def _until(
    schedule: Schedule, names: Sequence[str], times: Sequence[float]
) -> tuple[Floats, Floats]:
    """Straight stretches of a schedule that end at its breakpoints and at times, with inputs."""
    straight = schedule.stretches()
    points, values = straight.time(), straight.inputs(names)
    ends = np.unique(np.concatenate((points, np.asarray(times, dtype=float))))
    stretch = np.searchsorted(points, ends[:-1], side="right") - 1
    inputs, later = values[stretch], ends[:-1] - points[stretch]
    for k, name in enumerate(names):
        if not is_rate(name):
            inputs[:, k] += inputs[:, names.index(rate_of(name))] * later
    return np.diff(ends), inputs
