"""Results through slow time: peaks, amplitudes at given times, recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from slipmode.fmu import StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.settling import shortened
from slipmode.runner.run import run
from slipmode.runner.scene.schedule import make_schedule
from slipmode.runner.scene.sections import Scene
from slipmode.runner.study.outputs.outputs import Batch

# Parts of the table's range. Above the first no run starts. A run that stops above the second is
# repeated on a larger table: close to the edge it may find no step that stays inside.
_START, _STOP = 0.99, 0.9


def run_through(scene: Scene, excited: Excited, model: Model, times: Sequence[float]) -> Batch:
    """Return the peak |a| of a run, and |a| at some times, on a model of several scenes."""
    modes = excited.modes
    natural = dict(zip(modes, excited.reduced.frequency.tolist(), strict=True))
    schedule = make_schedule(scene, natural)
    if scene.model.formulation == "consistent":
        excited = excited.started(schedule)

    def nothing(reason: str, *, outside: bool = False) -> Batch:
        return Batch({}, [reason], np.array([outside]))

    if times and max(times) > scene.run.duration:
        return nothing(f"outputs.times: run.duration is {scene.run.duration:g}")
    scale = (1.0, 1.0)
    if scene.limit_scale is not None:
        scale = scene.limit_scale.range(0.0, 0.0)
    if np.any(np.abs(excited.amplitude) > _START * scale[0] * model.table.amplitude_range):
        return nothing("initial: outside the friction table", outside=True)
    rows = [excited.first_row()]
    try:
        component = excited.component(model, scene.run.tolerance)
        names = component.input_names
        if times:
            straight = replace(schedule.stretches(), points=tuple(times))
            steps = straight.durations(), straight.inputs(names)
        else:
            steps = shortened(schedule, model, modes, names)
        rows += [outputs[:, : rows[0].size].copy() for outputs in component.trace(*steps)]
    except StoppedError as stop:
        reached = _moduli(np.concatenate([*rows, stop.outputs[:, : rows[0].size]]))
        if scene.limit_scale is not None:
            scale = scene.limit_scale.range(0.0, stop.time)
        near = bool(np.any(reached > _STOP * scale[0] * model.table.amplitude_range))
        return nothing(str(stop), outside=stop.left_table or near)
    except SlipmodeError as refusal:
        return nothing(str(refusal))
    traced = np.concatenate(rows)
    size = _moduli(traced)
    at = [np.argmin(np.abs(traced[:, 0] - t)) for t in times]
    values = {"peak": size.max(axis=0)[np.newaxis], "at": size[at].T[np.newaxis]}
    return Batch(values, [""], np.zeros(1, dtype=bool))


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
