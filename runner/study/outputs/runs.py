"""Results through slow time: peaks, amplitudes at given times, recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from slipmode.fmu import StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.settling import shortened
from slipmode.runner.run import run
from slipmode.runner.scene.schedule import Schedule, is_rate, make_schedule, rate_of
from slipmode.runner.scene.sections import Scene

# Parts of the table's range. Above the first no run starts. A run that stops above the second is
# repeated on a larger table: close to the edge it may find no step that stays inside.
_START, _STOP = 0.99, 0.9


@dataclass(frozen=True, eq=False)
class Run:
    """|a| of a run: `peak` (modes,) and `at` times (modes, times); `reason`, see `Batch`."""

    peak: Floats
    at: Floats
    reason: str
    outside: bool = False

    __repr__ = short_repr


def run_through(scene: Scene, excited: Excited, model: Model, times: Sequence[float]) -> Run:
    """Run a scene on a model, which may be shared with other scenes."""
    modes = excited.modes
    natural = dict(zip(modes, excited.reduced.frequency.tolist(), strict=True))
    schedule = make_schedule(scene, natural)
    if scene.model.formulation == "consistent":
        excited = excited.started(schedule)
    nothing = Run(np.full(len(modes), np.nan), np.full((len(modes), len(times)), np.nan), "")
    if times and max(times) > scene.run.duration:
        return replace(nothing, reason=f"outputs.times: run.duration is {scene.run.duration:g}")
    scale = (1.0, 1.0)
    if scene.limit_scale is not None:
        scale = scene.limit_scale.range(0.0, 0.0)
    if np.any(np.abs(excited.amplitude) > _START * scale[0] * model.table.amplitude_range):
        return replace(nothing, reason="initial: outside the friction table", outside=True)
    rows = [excited.first_row()]
    try:
        component = excited.component(model, scene.run.tolerance)
        names = component.input_names
        if times:
            steps = _until(schedule, names, times)
        else:
            steps = shortened(schedule, model, modes, names)
        rows += [outputs[:, : rows[0].size].copy() for outputs in component.trace(*steps)]
    except StoppedError as stop:
        reached = _moduli(np.concatenate([*rows, stop.outputs[:, : rows[0].size]]))
        if scene.limit_scale is not None:
            scale = scene.limit_scale.range(0.0, stop.time)
        near = bool(np.any(reached > _STOP * scale[0] * model.table.amplitude_range))
        return replace(nothing, reason=str(stop), outside=stop.left_table or near)
    except SlipmodeError as refusal:
        return replace(nothing, reason=str(refusal))
    traced = np.concatenate(rows)
    size = _moduli(traced)
    at = [np.argmin(np.abs(traced[:, 0] - t)) for t in times]
    return Run(size.max(axis=0), size[at].T, "")


def record(scene: Scene, folder: Path, number: int) -> str:
    """Record the run of a sample; return why there is no recording, or nothing."""
    try:
        run(replace(scene, name=f"sample-{number:06d}"), folder)
    except SlipmodeError as refusal:
        return str(refusal)
    return ""


def _moduli(traced: Floats) -> Floats:
    """Return |a| (rows, modes) of rows of outputs."""
    return np.hypot(traced[:, 1::2], traced[:, 2::2])


def _until(
    schedule: Schedule, names: Sequence[str], times: Sequence[float]
) -> tuple[Floats, Floats]:
    """Return straight stretches of a schedule that end at breakpoints and at times, with inputs.

    See `shortened` for what is returned.
    """
    straight = schedule.stretches()
    points, values = straight.time(), straight.inputs(names)
    ends = np.unique(np.concatenate((points, np.asarray(times, dtype=float))))
    stretch = np.searchsorted(points, ends[:-1], side="right") - 1
    inputs, later = values[stretch], ends[:-1] - points[stretch]
    for k, name in enumerate(names):
        if not is_rate(name):
            inputs[:, k] += inputs[:, names.index(rate_of(name))] * later
    return np.diff(ends), inputs
