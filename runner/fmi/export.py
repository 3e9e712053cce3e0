"""A scene's model as an FMU that starts as the scene does."""

from __future__ import annotations

from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Any

from slipmode import fmu
from slipmode.fmu.description.options import FmiVersion, Stimuli
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
    *,
    headroom: float = HEADROOM,
    contacts: bool = False,
    progress: bool = False,
    **options: Any,
) -> Path:
    """Export the model that a scene needs.

    Inputs and amplitudes start as in the scene at t = 0; the importer sets the inputs later.
    Contact motion is among the outputs if any part of the scene uses it. The declared step is the
    scene's, or a part of it that fixed-step integrators can take in Model Exchange. The FMU
    computes in slow time: a warning says so if the estimated transient error of the scene is above
    the allowed one.

    Parameters
    ----------
    scene : Scene, path of a scene file, or name of a shipped scene
    output : path, optional
        Default: the scene's name with .fmu, in the present folder.
    fmi : {2, 3}
        Version of the standard.
    headroom : float
        Range of the friction table relative to the range that the scene needs, 1 or more, rounded
        up to eighths: for importers that force the model harder.
    contacts : bool
        Adds the contacts to the outputs if the scene has no [[contact]] window.
    progress : bool
        Shows progress bars on work longer than a second.
    **options
        `platforms` and `origin` of `slipmode.fmu.export`.
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
        **options,
    )


def _stimuli(plan: Plan) -> Stimuli:
    """Return the inputs that the scripts of a scene set."""
    scripts = tuple(plan.schedule.scripts)
    names = (*scripts, *map(rate_of, scripts))
    return Stimuli(names, plan.schedule.durations(), plan.schedule.inputs(names))
