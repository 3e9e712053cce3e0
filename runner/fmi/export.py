"""A scene's model as an FMU that starts as the scene does."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from os import PathLike
from pathlib import Path

from slipmode import fmu
from slipmode.fmu.description.description import FmiVersion, Origin
from slipmode.fmu.description.reference_result import Stimuli
from slipmode.rom import SlipmodeError
from slipmode.rom.validity import warn
from slipmode.runner.fmi.command import HEADROOM
from slipmode.runner.fmi.force_range import largest_forces
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.plan.time_scales import euler_step
from slipmode.runner.scene.scene import Scene, load_scene
from slipmode.runner.scene.schedule import rate_of


def export_fmu(
    scene: Scene | str | PathLike[str],
    output: str | PathLike[str] | None = None,
    fmi: FmiVersion = 3,
    platforms: Sequence[str] = (),
    *,
    headroom: float = HEADROOM,
    contacts: bool = False,
    origin: Origin | None = None,
    progress: bool = False,
) -> Path:
    """Export the model that a scene needs.

    Inputs and amplitudes start as in the scene at t = 0; what happens to the inputs later is up
    to the importer. Contact motion is among the outputs if the scene asks for it anywhere. The
    step that it declares is the scene's, or a part of it that fixed-step integrators can take in
    Model Exchange. All of it is in slow time: a warning says so where the estimated transient
    error of the scene is above the allowed one.

    Parameters
    ----------
    scene : Scene, path of a scene file, or name of a shipped scene
    output : path, optional
        Default: the scene's name with .fmu, in the present folder.
    fmi, platforms
        As in `slipmode.fmu.archive.export`.
    headroom : float
        Range of the friction table relative to what the scene needs, 1 or more, rounded up to
        eighths: for importers that force the model harder.
    contacts : bool
        Have the contacts among the outputs though the scene has no [[contact]] window.
    origin
        As in `slipmode.fmu.archive.export`.
    progress : bool
        Progress bars on work longer than a second.
    """
    if not (isfinite(headroom) and headroom >= 1.0):
        raise SlipmodeError(f"range: must be a finite number >= 1, got {headroom:g}")
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    plan = make_plan(scene.in_slow_time(), progress=progress)
    warn(each for each in plan.decisions if each.subject == "transients")
    elastic = plan.scene.output.elastic
    contact = bool(scene.contact or elastic or contacts)
    model, _ = plan.model(contact=contact, headroom=headroom, progress=progress)
    names = list(plan.schedule.scripts)
    (first,) = plan.schedule.inputs(names, slice(1)).tolist()
    return fmu.export(
        model,
        output or f"{scene.name}.fmu",
        plan.excited.force_patterns,
        fmi=fmi,
        platforms=platforms,
        contact=contact,
        elastic=elastic,
        mode_names=plan.excited.modes,
        name=scene.title,
        start=dict(zip(names, first, strict=True)) | plan.excited.start(),
        largest_force=largest_forces(plan, model),
        stop_time=scene.run.duration,
        step_size=euler_step(plan, model),
        reference_step=scene.run.step,
        stimuli=_stimuli(plan),
        tolerance=scene.run.tolerance,
        origin=origin,
    )


def _stimuli(plan: Plan) -> Stimuli:
    """What the scripts of a scene do to the inputs."""
    scripts = tuple(plan.schedule.scripts)
    names = (*scripts, *map(rate_of, scripts))
    return Stimuli(names, plan.schedule.durations(), plan.schedule.inputs(names))
