"""Results of a batch of samples on one model: without time, and through slow time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Self

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, phasor
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.backbone import resonance_peaks
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.steady_points import steady_points
from slipmode.runner.plan.amplitude_range import Stretches, along_run, shortened
from slipmode.runner.plan.excited import Excited
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
        refused = f"outputs.dofs: must be 0 to {n - 1}, got {highest}"
        batch.reason[:] = [why or refused for why in batch.reason]
        return batch
    read = {k: each for k, each in enumerate(scenes) if not isinstance(each, str)}
    places = list(read)
    columns = [modes.index(mode) for mode in shared.excited.modes]
    dofs = Dofs(outputs.dofs, model, shared.excited, shared.static)
    if read and (outputs.steady or outputs.resonance or outputs.curve):
        loads = Loads.of(list(read.values()), shared.excited)
        for kind, solve in (("steady", steady_states), ("resonance", peaks), ("curve", curves)):
            if getattr(outputs, kind):
                batch.add(places, columns, solve(outputs, model, loads, dofs))
    for k, scene in read.items():
        if outputs.runs and not batch.reason[k]:
            found = run_through(scene, shared.excited, model, outputs.times, dofs)
            batch.add([k], columns, found)
    if shared.samples.recordings is not None:
        for k, scene in read.items():
            if batch.reason[k]:
                continue
            try:
                run(replace(scene, name=f"sample-{numbers[k]:06d}"), shared.samples.recordings)
            except SlipmodeError as refusal:
                batch.reason[k] = str(refusal)
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

    def displacements(
        self, name: str, amplitude: Complexes, frequency: Floats, force: Complexes, scale: Floats
    ) -> dict[str, Floats]:
        """Return displacements (points, modes, dofs) of an output; none without DOFs.

        `amplitude`, `frequency` and the modal `force` are (points, modes), the `scale` of limits
        and preloads is (points,). NaN where the amplitude is NaN.
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
                frequency[known],
                force[known],
                applied,
                scale[known],
                self.static,
            )
            found[known] = np.stack([motion.displacement(dof) for dof in self.dofs], axis=-1)
        return {f"{name}_displacement": found}


@frozen
class Loads:
    """The forces at the end of scenes."""

    excited: Excited
    frequency: Floats  # (samples, modes) [rad/s]
    # (samples, modes): F_j exp(i phase_j), modal, divided by `scale` [N kg^-1/2]: the friction
    # table is for limits of scale 1
    excitation: Complexes
    scale: Floats  # (samples, 1): Scale of limits and preloads; results are multiplied by it

    @property
    def force(self) -> Complexes:
        """F_j exp(i phase_j), modal, (samples, modes) [N kg^-1/2]."""
        return np.asarray(self.scale * self.excitation)

    @classmethod
    def of(cls, scenes: Sequence[Scene], excited: Excited) -> Self:
        """Return the loads of scenes with the same modes."""
        shape = len(scenes), len(excited.modes)
        frequency = np.tile(excited.reduced.frequency, (shape[0], 1))
        force, phase, scale = np.zeros(shape), np.zeros(shape), np.ones((shape[0], 1))
        for k, scene in enumerate(scenes):
            end = scene.run.duration
            if scene.limit_scale is not None:
                scale[k] = scene.limit_scale.value_before(end)
            for j, mode in enumerate(excited.modes):
                if (forcing := scene.forcing.get(mode)) is not None:
                    force[k, j] = forcing.amplitude.value_before(end)
                    frequency[k, j] = forcing.frequency.value_before(end)
                    phase[k, j] = forcing.phase.value_before(end)
        excitation = phasor(excited.modal_force * force, phase) / scale
        return cls(excited, frequency, excitation, scale)


def steady_states(outputs: Outputs, model: Model, loads: Loads, dofs: Dofs) -> Batch:
    """Return |a| and its phase."""
    found = steady_points(
        model,
        loads.frequency,
        AppliedForces.of(model.reduced, loads.excited.force_patterns),
        loads.excitation,
    )
    a = loads.scale * found.amplitude
    values = {"steady": np.abs(a), "steady_phase": np.angle(a)}
    values |= dofs.displacements("steady", a, loads.frequency, loads.force, loads.scale[:, 0])
    return Batch(values, found.reason, found.outside)


def curves(outputs: Outputs, model: Model, loads: Loads, dofs: Dofs) -> Batch:
    """Return |a| over the frequency of a mode, (samples, modes, points).

    A sample with a refused point is refused.
    """
    assert outputs.curve is not None
    axis, n, modes = outputs.curve.frequency, len(loads.scale), loads.excited.modes
    if outputs.curve.mode not in modes:
        reason = f"outputs.curve.mode: nothing moves mode {outputs.curve.mode}"
        return Batch.refused("curve", (n, len(modes), axis.size), reason)
    frequency = np.repeat(loads.frequency, axis.size, axis=0)
    frequency[:, modes.index(outputs.curve.mode)] = np.tile(axis, n)
    excitation = np.repeat(loads.excitation, axis.size, axis=0)
    found = steady_points(
        model, frequency, AppliedForces.of(model.reduced, loads.excited.force_patterns), excitation
    )
    scale = np.repeat(loads.scale, axis.size, axis=0)
    a, force = scale * found.amplitude, scale * excitation
    values = {"curve": np.abs(a)}
    values |= dofs.displacements("curve", a, frequency, force, scale[:, 0])
    by_sample = {
        name: each.reshape(n, axis.size, *each.shape[1:]).swapaxes(1, 2)
        for name, each in values.items()
    }
    reasons = np.array(found.reason, dtype=object).reshape(n, axis.size)
    first = [next(filter(None, row), "") for row in reasons]
    outside = np.asarray(found.outside.reshape(n, axis.size).any(axis=1))
    return Batch(by_sample, first, outside)


def peaks(outputs: Outputs, model: Model, loads: Loads, dofs: Dofs) -> Batch:
    """Return the highest resonance peak of modes, and its frequency."""
    shape, modes = loads.excitation.shape, loads.excited.modes
    peak, frequency = np.full(shape, np.nan), np.full(shape, np.nan)
    reason, outside = [""] * shape[0], np.zeros(shape[0], dtype=bool)
    moved: dict[str, Floats] = {}
    for mode in outputs.resonance:
        if mode not in modes:
            why = f"outputs.resonance: nothing moves mode {mode}"
            return Batch.refused("resonance", shape, why)
        j = modes.index(mode)
        try:
            relative, frequency[:, j] = resonance_peaks(model, j, np.abs(loads.excitation[:, j]))
        except SlipmodeError as refusal:
            return Batch.refused("resonance", shape, str(refusal))
        peak[:, j] = loads.scale[:, 0] * relative
        outside |= np.isnan(relative)
        alone, Omega = np.arange(len(modes)) == j, loads.frequency.copy()
        Omega[:, j] = frequency[:, j]
        a = np.where(alone, peak[:, [j]], 0.0).astype(complex)
        force = 1j * np.abs(np.where(alone, loads.force, 0.0))  # at 90 degrees
        found = dofs.displacements("resonance", a, Omega, force, loads.scale[:, 0])
        for name, each in found.items():
            moved.setdefault(name, np.full(each.shape, np.nan))[:, j] = each[:, j]
    for k in np.flatnonzero(outside):
        reason[k] = f"amplitude: outside the friction table, to {model.table.amplitude_range}"
    values = {"resonance": peak, "resonance_frequency": frequency, **moved}
    return Batch(values, reason, outside)


def run_through(
    scene: Scene, excited: Excited, model: Model, times: Sequence[float], dofs: Dofs
) -> Batch:
    """Return the peak |a| of a run, its transient error, and |a| at some times.

    Several scenes share the model.
    """
    modes = excited.modes
    natural = dict(zip(modes, excited.reduced.frequency.tolist(), strict=True))
    schedule = make_schedule(scene, natural)
    excited = excited.started(schedule)

    def nothing(reason: str, *, outside: bool = False) -> Batch:
        return Batch({}, [reason], np.array([outside]))

    if times and max(times) > scene.run.duration:
        return nothing(f"outputs.times: run.duration is {scene.run.duration:g}")
    largest, limit_scale = model.table.amplitude_range, scene.limit_scale or Script.constant(1.0)
    if np.any(np.abs(excited.amplitude) > 0.99 * limit_scale.range(0.0, 0.0)[0] * largest):
        return nothing("initial: outside the friction table", outside=True)
    try:
        component = excited.component(model, scene.run.tolerance)
        names = component.input_names
        if times:
            straight = replace(schedule.stretches(), points=tuple(times))
            lengths = straight.durations()
            steps = Stretches(lengths, straight.inputs(names), lengths, names)
        else:
            steps = shortened(schedule, model, modes, names)
        path = excited.follow(component, steps.durations, steps.inputs)
    except SlipmodeError as refusal:
        return nothing(str(refusal))
    size, stop = np.abs(path.amplitude), path.stop
    if stop is not None:
        # close to the edge of the table a run may find no step that stays inside
        near = bool(np.any(size > 0.9 * limit_scale.range(0.0, stop.time)[0] * largest))
        return nothing(str(stop), outside=stop.left_table or near)
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
        then = _loads_at(excited, steps, path.time[points])
        moved = dofs.displacements(name, path.amplitude[points], *then)
        for key, each in moved.items():  # the point of each mode, or the same points of all
            of_modes = np.einsum("jjd->jd", each) if name == "peak" else each.swapaxes(0, 1)
            values[key] = of_modes[np.newaxis]
    return Batch(values, [""], np.zeros(1, dtype=bool))


def _loads_at(
    excited: Excited, steps: Stretches, time: Floats
) -> tuple[Floats, Complexes, Floats]:
    """Return frequencies, modal forces F_j exp(i phase_j), and scales just before times."""
    before, _ = steps.around(time)
    frequency, force, phase = (
        np.stack([steps.values(f"{name}_{m}", time, before) for m in excited.modes], axis=1)
        for name in ("frequency", "force", "phase")
    )
    return (
        frequency,
        phasor(excited.modal_force * force, phase),
        steps.values("limit_scale", time, before),
    )
