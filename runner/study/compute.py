"""Results of a batch of samples on one model: without time, and through slow time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, phasor
from slipmode.rom.reduction.nonlinear.stiffness import refuse_nonlinear_stiffness
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.backbone import resonance_peaks
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.steady_points import steady_points
from slipmode.runner.plan.amplitude_range import along_run, shortened
from slipmode.runner.plan.excited import Excited, Loads
from slipmode.runner.run import run
from slipmode.runner.scene.schedule import make_schedule
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.sections import Scene
from slipmode.runner.study.sample_outputs import Batch, Outputs
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
    if (highest := max(outputs.dofs, default=0)) >= (n := shared.excited.reduced.n_dofs):
        batch.refuse(range(len(scenes)), f"outputs.dofs: must be 0 to {n - 1}, got {highest}")
        return batch
    read = {k: each for k, each in enumerate(scenes) if not isinstance(each, str)}
    places = list(read)
    columns = [modes.index(mode) for mode in shared.excited.modes]
    dofs = Dofs(outputs.dofs, model, shared.excited, shared.static)
    if read and (outputs.steady or outputs.resonance or outputs.curve):
        loads = loads_at_end(list(read.values()), shared.excited)
        for kind, solve in (("steady", steady_states), ("resonance", peaks), ("curve", curves)):
            if getattr(outputs, kind):
                try:
                    batch.add(places, columns, solve(outputs, loads, dofs))
                except SlipmodeError as refusal:
                    batch.refuse(places, str(refusal))
    for k, scene in read.items():
        try:
            if outputs.runs and not batch.reason[k]:
                batch.add([k], columns, run_through(scene, outputs.times, dofs))
            if shared.samples.recordings is not None and not batch.reason[k]:
                run(replace(scene, name=f"sample-{numbers[k]:06d}"), shared.samples.recordings)
        except SlipmodeError as refusal:
            batch.refuse([k], str(refusal))
    for values in batch.values.values():
        values[[bool(why) for why in batch.reason]] = np.nan
    return batch


@frozen
class Dofs:
    """The DOFs whose displacement amplitudes are outputs; see `SteadyMotion`."""

    dofs: tuple[int, ...]
    model: Model
    excited: Excited
    static: Floats | None  # `SceneModel.static`

    def displacements(self, name: str, amplitude: Complexes, loads: Loads) -> dict[str, Floats]:
        """Return displacements (points, modes, dofs) of an output; none without DOFs.

        NaN where the amplitude (points, modes) is NaN.
        """
        if not self.dofs:
            return {}
        found = np.full((*amplitude.shape, len(self.dofs)), np.nan)
        known = np.isfinite(amplitude).all(axis=1)
        if known.any():
            applied = AppliedForces.of(self.model.reduced, self.excited.force_patterns)
            motion = SteadyMotion(
                self.model,
                amplitude[known],
                loads.frequency[known],
                loads.force[known],
                applied,
                loads.scale[known, 0],
                self.static,
            )
            found[known] = np.stack([motion.displacement(dof) for dof in self.dofs], axis=-1)
        return {f"{name}_displacement": found}


def loads_at_end(scenes: Sequence[Scene], excited: Excited) -> Loads:
    """Return the loads at the end of scenes with the same modes."""
    shape = len(scenes), len(excited.modes)
    frequency = np.tile(excited.reduced.frequency, (shape[0], 1))
    force, phase, scale = np.zeros(shape), np.zeros(shape), np.ones((shape[0], 1))
    for k, scene in enumerate(scenes):
        end = scene.run.duration
        if scene.limit_scale is not None:
            refuse_nonlinear_stiffness(
                excited.reduced, "a study with limits.scale", "vary the limits of the contacts"
            )
            scale[k] = scene.limit_scale.value_before(end)
        for j, mode in enumerate(excited.modes):
            if (forcing := scene.forcing.get(mode)) is not None:
                force[k, j] = forcing.amplitude.value_before(end)
                frequency[k, j] = forcing.frequency.value_before(end)
                phase[k, j] = forcing.phase.value_before(end)
    return Loads(phasor(excited.modal_force * force, phase), frequency, scale)


def steady_states(outputs: Outputs, loads: Loads, dofs: Dofs, name: str = "steady") -> Batch:
    """Return |a| and its phase. The table is for limits of scale 1, a(F; s) = s a(F / s; 1)."""
    found = steady_points(
        dofs.model,
        loads.frequency,
        AppliedForces.of(dofs.model.reduced, dofs.excited.force_patterns),
        loads.force / loads.scale,
    )
    a = loads.scale * found.amplitude
    values = {name: np.abs(a), f"{name}_phase": np.angle(a)}
    return Batch(values | dofs.displacements(name, a, loads), found.reason, found.outside)


def curves(outputs: Outputs, loads: Loads, dofs: Dofs) -> Batch:
    """Return |a| over the frequency of a mode, (samples, modes, points).

    A sample with a refused point is refused.
    """
    assert outputs.curve is not None
    axis, n, modes = outputs.curve.frequency, len(loads.scale), dofs.excited.modes
    if outputs.curve.mode not in modes:
        raise SlipmodeError(f"outputs.curve.mode: nothing moves mode {outputs.curve.mode}")
    sample = np.repeat(np.arange(n), axis.size)
    frequency = loads.frequency[sample]
    frequency[:, modes.index(outputs.curve.mode)] = np.tile(axis, n)
    points = Loads(loads.force[sample], frequency, loads.scale[sample])
    found = steady_states(outputs, points, dofs, "curve")
    values = {
        name: each.reshape(n, axis.size, *each.shape[1:]).swapaxes(1, 2)
        for name, each in found.values.items()
    }
    reasons = np.array(found.reason, dtype=object).reshape(n, axis.size)
    first = [next(filter(None, row), "") for row in reasons]
    return Batch(values, first, np.asarray(found.outside.reshape(n, axis.size).any(axis=1)))


def peaks(outputs: Outputs, loads: Loads, dofs: Dofs) -> Batch:
    """Return the highest resonance peak of modes, and its frequency."""
    shape, modes, model = loads.force.shape, dofs.excited.modes, dofs.model
    peak, frequency = np.full(shape, np.nan), np.full(shape, np.nan)
    outside = np.zeros(shape[0], dtype=bool)
    moved: dict[str, Floats] = {}
    for mode in outputs.resonance:
        if mode not in modes:
            raise SlipmodeError(f"outputs.resonance: nothing moves mode {mode}")
        j = modes.index(mode)
        excitation = np.abs(loads.force[:, j] / loads.scale[:, 0])
        relative, frequency[:, j] = resonance_peaks(model, j, excitation)
        peak[:, j] = loads.scale[:, 0] * relative
        outside |= np.isnan(relative)
        alone, Omega = np.arange(len(modes)) == j, loads.frequency.copy()
        Omega[:, j] = frequency[:, j]
        a = np.where(alone, peak[:, [j]], 0.0).astype(complex)
        force = 1j * np.abs(np.where(alone, loads.force, 0.0))  # at 90 degrees
        found = dofs.displacements("resonance", a, Loads(force, Omega, loads.scale))
        for name, each in found.items():
            moved.setdefault(name, np.full(each.shape, np.nan))[:, j] = each[:, j]
    why = f"amplitude: outside the friction table, to {model.table.amplitude_range}"
    values = {"resonance": peak, "resonance_frequency": frequency, **moved}
    return Batch(values, [why if out else "" for out in outside], outside)


def run_through(scene: Scene, times: Sequence[float], dofs: Dofs) -> Batch:
    """Return the peak |a| of a run, its transient error, and |a| at some times."""
    excited, model, modes = dofs.excited, dofs.model, dofs.excited.modes
    natural = dict(zip(modes, excited.reduced.frequency.tolist(), strict=True))
    schedule = make_schedule(scene, natural)
    excited = excited.started(schedule)
    if times and max(times) > scene.run.duration:
        raise SlipmodeError(f"outputs.times: run.duration is {scene.run.duration:g}")
    largest, limit_scale = model.table.amplitude_range, scene.limit_scale or Script.constant(1.0)
    if np.any(np.abs(excited.amplitude) > 0.99 * limit_scale.range(0.0, 0.0)[0] * largest):
        return Batch({}, ["initial: outside the friction table"], np.ones(1, dtype=bool))
    steps = (
        replace(schedule.stretches(), points=tuple(times))
        if times
        else shortened(schedule, model, modes)
    )
    path = excited.follow(model, steps, scene.run.tolerance)
    size, stop = np.abs(path.amplitude), path.stop
    if stop is not None:
        # close to the edge of the table a run may find no step that stays inside
        near = np.any(size > 0.9 * limit_scale.range(0.0, stop.time)[0] * largest)
        return Batch({}, [str(stop)], np.array([stop.left_table or near]))
    _, error = along_run(excited, model, steps, path)
    at = [np.argmin(np.abs(path.time - t)) for t in times]
    largest_scale = limit_scale.range(0.0, scene.run.duration)[1]
    values = {
        "peak": size.max(axis=0)[np.newaxis],
        "at": size[at].T[np.newaxis],
        "run_error": largest_scale * error.max(axis=0, initial=0.0)[np.newaxis],
    }
    largest_at = size.argmax(axis=0)
    for name, points in (("peak", largest_at), ("at", np.array(at, dtype=np.intp))):
        before = partial(steps.around, times=path.time[points], after=False)
        then = excited.loads(before)
        moved = dofs.displacements(name, path.amplitude[points], then)
        for key, each in moved.items():  # the point of each mode, or the same points of all
            of_modes = np.einsum("jjd->jd", each) if name == "peak" else each.swapaxes(0, 1)
            values[key] = of_modes[np.newaxis]
    return Batch(values, [""], np.zeros(1, dtype=bool))
