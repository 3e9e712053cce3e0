"""Compare a scene in slow time, or on reduced coordinates, with full-order integration."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from os import PathLike
from pathlib import Path
from time import perf_counter
from typing import Literal, cast

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full import (
    FullMotion,
    aeroelastic,
    component_modes,
    integrate,
)
from slipmode.rom.full.convergence import relative_rms
from slipmode.rom.full.structures import Projection
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.plan.blades import plan_blades
from slipmode.runner.plan.excited import contact_channels
from slipmode.runner.plan.plan import Intervals, ModesPlan
from slipmode.runner.plan.planning import plan_scene
from slipmode.runner.plan.waves import ExcitedWaves
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Header, Recorder, describe_run
from slipmode.runner.run import PASSES, open_recorder, run
from slipmode.runner.scene.scene import Scene, Window, load_scene
from slipmode.runner.transients.full_order import (
    FullOrder,
    excitation_of,
    friction_loss,
    initial_state,
)
from slipmode.runner.transients.motion import FastMotion, record_contacts
from slipmode.runner.transients.passes.loop import Destination
from slipmode.runner.validation.all_sectors import blades_in_full, check_one_wave, sector_in_full


@dataclass(frozen=True)
class Comparison:
    """One quantity of the reduced model against full order."""

    subject: str
    error: float  # Relative; of a signal the largest RMS over contacts or modes
    # The same between the full-order run and a run at twice the step; of large structures, the
    # change by half as many component modes is added
    reference_error: float


@frozen
class Validation:
    """The result of `validate`.

    Attributes
    ----------
    comparisons : list of Comparison
    slow_seconds, table_seconds, full_seconds : float
        Wall time of the slow run with its reconstruction, of the friction table, and of the
        full-order run.
    recordings : list of Path
        Both motions in one recording, for replay side by side.
    coordinates : int
        Number of coordinates at full order: of the structure, or component modes.
    windows : tuple of Window
        The times that are compared.
    reduced : {"slow time", "reduced coordinates"}
        How the reduced motion was computed: a scene with `model.table = "none"` is integrated.
    full_order : sequence of (start, end)
        Stretches of the reduced run that the plan has at full order [s].
    """

    comparisons: list[Comparison]
    slow_seconds: float
    table_seconds: float
    full_seconds: float
    recordings: list[Path]
    coordinates: int
    windows: tuple[Window, ...]
    reduced: Literal["slow time", "reduced coordinates"]
    full_order: Intervals = ()

    def compared(self) -> str:
        """Return the windows that were compared, in words."""
        times = ", ".join(f"{each.start:g} to {each.end:g} s" for each in self.windows)
        text = f"compared: {self.reduced} and full order, t = {times}"
        stretches = ", ".join(
            f"{start:.6g} to {end:.6g} s"
            for start, end in self.full_order
            if any(start < each.end and each.start < end for each in self.windows)
        )
        if not stretches:
            return text
        return (
            f"{text}. The scene integrates {stretches} at full order, so that slow time is not "
            'compared there: choose a later window, or model.transients = "slow"'
        )


def validate(
    scene: Scene | str | PathLike[str],
    output: str | PathLike[str] = "logs",
    *,
    progress: bool = False,
) -> Validation:
    """Run a scene both ways and compare the motion in its contact windows.

    Without a [[contact]] window the last 20 periods are compared. With `model.table = "none"` the
    motion is integrated on the reduced coordinates. The folder `output` receives
    <scene>.validation.mcap and .rrd. Of a mistuned disk a DOF of all blades is compared in
    [[elastic]] windows, in the last 512 samples of each; the error belongs to the worst blade.
    Raises SlipmodeError if the scene is refused.

    Parameters
    ----------
    scene : Scene, path of a scene file, or name of a shipped scene
    output : path
        Folder of the recordings.
    progress : bool
        Shows progress bars on work longer than a second.
    """
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    if scene.limit_scale is not None:
        key = "wear" if scene.wear else "scale"
        raise SlipmodeError(f"limits.{key}: must be left out, because full order has fixed limits")
    if scene.nonlinear_stiffness:
        raise SlipmodeError(
            "nonlinear_stiffness: must be left out, because full order does not include it"
        )
    if scene.mistuning:
        return _validate_blades(scene, output, progress=progress)
    started = perf_counter()
    plan = with_window(_planned(scene, progress=progress))
    model = plan.model(progress=progress)[0] if scene.tabulated else None
    tabulated = perf_counter()
    energy: float | None
    if scene.model.table == "none":
        motion, energy = integrated_motion(plan)
    else:
        motion, energy = slow_motion(plan, model)
    finished = perf_counter()
    full = reference(plan, motion.time)
    found = Validation(
        comparisons=_compare(plan, motion, energy, full),
        slow_seconds=finished - tabulated,
        table_seconds=tabulated - started,
        full_seconds=full.seconds,
        recordings=[
            Path(output) / f"{scene.name}.validation.{ending}" for ending in ("mcap", "rrd")
        ],
        coordinates=full.coordinates,
        windows=plan.scene.contact,
        reduced="reduced coordinates" if scene.model.table == "none" else "slow time",
        full_order=plan.full_order,
    )
    _record(plan, model, motion, full.motion, found)
    return found


def _validate_blades(scene: Scene, output: str | PathLike[str], *, progress: bool) -> Validation:
    """Run a scene of a mistuned disk both ways. The recording has the slow motion alone."""
    plan = plan_blades(scene)
    if not scene.windows:
        last = _last_periods(scene, plan.excited.frequency[0])
        scene = replace(scene, elastic=(last,))
    named = replace(scene, name=f"{scene.name}.validation", log=replace(scene.log, mcap=True))
    recording = run(named, output, progress=progress)
    disk = recording.read().channels["/disk"]
    blades, sectors = plan.excited, plan.excited.disk.structure.sectors
    moved = disk.values[:, :sectors]
    started = perf_counter()
    fine = blades_in_full(plan, disk.time, 64)
    seconds = perf_counter() - started
    error, of_reference = (
        _worst(each, fine) for each in (moved, blades_in_full(plan, disk.time, 32))
    )
    return Validation(
        comparisons=[Comparison(f"DOF {blades.dof} of the worst blade", error, of_reference)],
        slow_seconds=recording.slow_seconds,
        table_seconds=recording.table_seconds,
        full_seconds=seconds,
        recordings=[path for path in (recording.mcap, recording.rrd) if path],
        coordinates=sectors * blades.n_dofs,
        windows=tuple(scene.windows),
        reduced="slow time",
    )


def _planned(scene: Scene, *, progress: bool) -> ModesPlan:
    """Return the plan of a scene whose structure can be integrated in full."""
    forced = scene.forcing.items()
    rotates = next((name for name, each in forced if each.quadrature is not None), None)
    if rotates and len(forced) == 2:
        raise SlipmodeError(
            f"forcing.{rotates}.quadrature: must be left out, because the reference has one "
            "force that does not rotate on each of two tones"
        )
    if scene.disk is None:
        return plan_scene(scene, structure=scene.build(), progress=progress)
    plan = plan_scene(scene, progress=progress)
    check_one_wave(plan)
    return plan


def slow_motion(plan: ModesPlan, model: Model | None) -> tuple[FastMotion, float | None]:
    """Return the motion in every window, and the energy that friction dissipated [J].

    The energy is not known for several modes on a tone, which have no `model`.
    """
    motions: list[FastMotion] = []
    destination = Destination(Recorder(()), keep=motions.append)
    tabulated = (model,) if model else ()
    pass_ = PASSES[plan.kind](plan, destination, *tabulated)
    pass_.run()
    return FastMotion.joined(motions), float(pass_.last_row[-1]) if model else None


def integrated_motion(plan: ModesPlan) -> tuple[FastMotion, float]:
    """Return the motion in every window, integrated on the reduced coordinates.

    The second value is the energy that friction dissipated until the end of the scene [J].
    """
    excited, times = plan.excited, _sample_times(plan)
    full = FullOrder(plan, excited.reduced)
    until_end = full.integrator.run(np.union1d(times, [plan.scene.run.duration]), full.first())
    every, seen = full.fast_motion(until_end), np.isin(until_end.time, times)
    motion = FastMotion(*(getattr(every, each.name)[seen] for each in fields(every)))
    return motion, float(friction_loss(excited.reduced.contacts, until_end)[-1])


def _sample_times(plan: ModesPlan) -> Floats:
    """Return the times of the samples in all windows."""
    return np.concatenate([plan.schedule.sample_times(window) for window in plan.scene.contact])


def with_window(plan: ModesPlan) -> ModesPlan:
    """Return the plan with a window of contact motion at its end if the scene has none."""
    if plan.scene.contact:
        return plan
    window = _last_periods(plan.scene, float(plan.excited.reduced.carrier.min()))
    return replace(plan, scene=replace(plan.scene, contact=(window,)))


def _last_periods(scene: Scene, frequency: float) -> Window:
    """Return a window of 20 periods of a frequency [rad/s] at the end of a scene."""
    end = scene.run.duration
    return Window((max(0.0, end - 20 * 2 * np.pi / frequency), end), 64)


def _compare(
    plan: ModesPlan, motion: FastMotion, energy: float | None, full: Reference
) -> list[Comparison]:
    time, seen = motion.time, np.isin(full.motion.time, motion.time)
    elements = plan.excited.contacts[0].contacts
    signals = {
        "modal displacement": (motion.modal[:, : len(plan.excited.reduced.modes)], "displacement"),
        "contact displacement": (motion.displacement, "contact_displacement"),
        "contact velocity": (motion.velocity, "contact_velocity"),
        "friction force": (motion.force, "contact_force"),
    }
    found = []
    for subject, (reduced, name) in signals.items():
        pairs = [(reduced, getattr(full.motion, name)[seen])]
        pairs += [(getattr(a, name)[seen], getattr(b, name)[seen]) for a, b in full.comparisons]
        if elements is not None and name in ("contact_displacement", "contact_force"):
            # the mean of a slider's position and force depends on its history
            pairs = [(_about_mean(plan, time, a), _about_mean(plan, time, b)) for a, b in pairs]
        error, *of_reference = (_worst(a, b) for a, b in pairs)
        found.append(Comparison(subject, error, sum(of_reference)))

    def spent_in(motion: FullMotion) -> float:
        return float(friction_loss(elements, motion)[-1])

    spent = spent_in(full.motion)
    if energy is not None and np.isfinite(spent):
        scale = spent if spent > 0 else 1.0
        change = sum(abs(spent_in(a) - spent_in(b)) for a, b in full.comparisons) / scale
        error = abs(energy - spent) / scale
        found.append(Comparison("energy dissipated by friction", error, change))
    return found


def _about_mean(plan: ModesPlan, time: Floats, signal: Floats) -> Floats:
    """Return a signal (samples, N_c) less its mean in each window."""
    moving = signal.copy()
    for window in plan.scene.contact:
        inside = (time >= window.start) & (time <= window.end)
        moving[inside] -= moving[inside].mean(axis=0)
    return moving


def _worst(signal: Floats, reference: Floats) -> float:
    """Return the largest relative RMS over the columns that move at all."""
    size = np.sqrt(np.mean(reference**2, axis=0))
    moving = size > 1e-6 * size.max(initial=0.0)
    if not moving.any():
        return 0.0
    return float(relative_rms(signal[:, moving], reference[:, moving]).max())


def _record(
    plan: ModesPlan, model: Model | None, motion: FastMotion, fine: FullMotion, found: Validation
) -> None:
    """Record both motions; the full-order channels begin with /full."""
    scene = plan.scene
    seen = np.isin(fine.time, motion.time)
    reduced, _ = plan.excited.contacts
    listed = contact_channels(reduced) + contact_channels(reduced, channels.FULL)
    title, run = f"{scene.title}: reduced and full order", describe_run(scene.text, model)
    header = Header(title, scene.text, run, scene.name)
    mcap, rrd = found.recordings
    mcap.parent.mkdir(parents=True, exist_ok=True)
    with open_recorder(header, listed, mcap, rrd) as recorder:
        recorder.event(float(motion.time[0]), "info", found.compared())
        for line in found.comparisons:
            words = f"{line.subject}: {percentage(line.error)} from full order"
            recorder.event(float(motion.time[0]), "info", words)
        exact = replace(
            motion,
            displacement=fine.contact_displacement[seen],
            velocity=fine.contact_velocity[seen],
            force=fine.contact_force[seen],
        )
        record_contacts(recorder, reduced, motion)
        record_contacts(recorder, reduced, exact, prefix=channels.FULL)


MOST_DOFS = 1000  # for which all modes are computed


@frozen
class Reference:
    """Motion at full order, with cheaper versions of it."""

    motion: FullMotion  # Its outputs are the retained modes
    # Pairs of motions whose difference is an error of `motion`: at twice the step; of large
    # structures also on half as many component modes
    comparisons: list[tuple[FullMotion, FullMotion]]
    coordinates: int  # Number of coordinates
    seconds: float  # Wall time of `motion` alone


def reference(plan: ModesPlan, times: Floats) -> Reference:
    """Return the motion of a scene at full order, at times and at its end.

    Structures of up to 1000 DOFs have all their modes, larger ones `rom.full.component_modes`.
    """
    excited, times = plan.excited, np.union1d(times, [plan.scene.run.duration])
    if plan.scene.disk is not None:
        return _of_all_sectors(plan, cast(ExcitedWaves, excited), times)
    coordinates = plan.structure.n_dofs
    small: Projection | None = None
    fewer: Projection | None = None
    if coordinates > MOST_DOFS:
        excitation = excitation_of(
            plan.excited.modes, np.array(excited.force_patterns), plan.schedule
        )
        # component modes are accurate up to seven times the fastest forcing
        highest = 7 * excitation.fastest(plan.scene.run.duration)
        arguments = plan.structure, excited.law, excitation.patterns, highest
        least = max(excited.reduced.modes) + 1  # the retained modes are among them
        found = component_modes(*arguments)
        if found.frequency.size < 2 * least:
            found = component_modes(*arguments, modes=2 * least)
        halved = component_modes(*arguments, modes=max(found.frequency.size // 2, least))
        small, fewer, coordinates = found.projection, halved.projection, found.structure.n_dofs
    started = perf_counter()
    fine = full_motion(plan, times, 64, small)
    seconds = perf_counter() - started
    coarse = full_motion(plan, times, 32, small)
    comparisons = [(coarse, fine)]
    if fewer is not None:
        comparisons.append((full_motion(plan, times, 32, fewer), coarse))
    return Reference(fine, comparisons, coordinates, seconds)


def _of_all_sectors(plan: ModesPlan, waves: ExcitedWaves, times: Floats) -> Reference:
    """Return the motion of sector 0 among all sectors of a bladed disk."""
    annulus = waves.disk.annulus()
    started = perf_counter()
    fine = sector_in_full(plan, waves, annulus, times, 64)
    seconds = perf_counter() - started
    coarse = sector_in_full(plan, waves, annulus, times, 32)
    return Reference(fine, [(coarse, fine)], annulus.n_dofs, seconds)


def full_motion(
    plan: ModesPlan, times: Floats, steps_per_period: float, on: Projection | None = None
) -> FullMotion:
    """Return the motion of a scene, with the retained modes as outputs.

    It is integrated on all modes of the structure, or on the coordinates of a projection.
    """
    reduced, structure = plan.excited.reduced, plan.structure
    excitation = excitation_of(
        plan.excited.modes, np.array(plan.excited.force_patterns), plan.schedule
    )
    start, shapes = initial_state(plan, excitation), reduced.mode_shapes
    if on is not None:
        structure, shapes = on.structure, on.to_coordinates @ shapes
        excitation, start = on.excitation(excitation), on.state(start)
    return integrate(
        aeroelastic(structure, reduced, shapes),
        plan.excited.law,
        excitation,
        times,
        steps_per_period=steps_per_period,
        outputs=as_dense(structure.mass @ shapes).T,
        start=start,
    )
