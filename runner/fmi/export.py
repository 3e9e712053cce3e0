"""A scene's model as an FMU that starts as the scene does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from math import ceil, isfinite
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode import fmu
from slipmode.fmu.description.options import FmiVersion, Stimuli
from slipmode.rom import Model, SlipmodeError
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.validity import warn
from slipmode.runner.plan.amplitude_range import shortened
from slipmode.runner.plan.plan import ModesPlan, Plan
from slipmode.runner.plan.planning import make_plan, plan_scene
from slipmode.runner.scene.scene import Scene, load_scene
from slipmode.runner.scene.schedule import is_rate

HEADROOM = 1.25  # forces a tenth above the shipped scenes' forces reach up to 1.19 times as far


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
    the allowed one. Of several modes on one tone, the FMU is for Co-Simulation only.

    Parameters
    ----------
    scene : Scene, path of a scene file, or name of a shipped scene
    output : path, optional
        Default: the scene's name with .fmu, in the present folder.
    fmi : {2, 3}
        Version of the standard.
    headroom : float
        Range of the friction table relative to the range that the scene needs, 1 or more, rounded
        up to eighths: for importers that force the model harder. A saved model keeps its range,
        and several modes on one tone have none.
    contacts : bool
        Adds the contacts to the outputs if the scene has no [[contact]] window.
    progress : bool
        Shows progress bars on work longer than a second.
    options
        `platforms` and `origin` of `slipmode.fmu.export`.
    """
    if not (isfinite(headroom) and headroom >= 1.0):
        raise SlipmodeError(f"range: must be a finite number >= 1, got {headroom:g}")
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    shares_tone, fixed = bool(scene.modes.tones), ""
    if shares_tone:
        fixed = "modes that share a tone have no table to extend"
    elif scene.saved_model is not None:
        fixed = "the model of model.file has its own"
    planned: Callable[..., Plan[Any]] = plan_scene if shares_tone else make_plan
    plan = planned(scene.in_slow_time(), progress=progress)
    if fixed and headroom not in (1.0, HEADROOM):
        raise SlipmodeError(f"range: must be left out, because {fixed}")
    elastic = plan.scene.output.elastic
    schedule, names = plan.schedule, plan.schedule.scripted
    inputs = schedule.inputs(names)
    first = zip(names, inputs[0].tolist(), strict=True)
    start = {name: value for name, value in first if not is_rate(name)}
    shared = {
        "fmi": fmi,
        "contact": bool(scene.contact or elastic or contacts),
        "elastic": elastic,
        "name": scene.title,
        "start": start,
        "stop_time": scene.run.duration,
        "step_size": scene.run.step,
        "reference_step": scene.run.step,
        "stimuli": Stimuli(names, schedule.durations(), inputs),
        "tolerance": scene.run.tolerance,
    }
    path, options = output or f"{scene.name}.fmu", shared | options
    if shares_tone:
        return fmu.export(plan.excited.tone_model, path, plan.excited.force_patterns, **options)
    if contacts and not plan.excited.reduced.n_contacts:
        raise SlipmodeError("contacts: must be left out, because the model of model.file has none")
    warn(each for each in plan.decisions if each.subject == "transients")
    model, _ = plan.model(contact=options["contact"], headroom=headroom, progress=progress)
    options |= {
        "mode_names": plan.excited.modes,
        "start": start | plan.excited.start(),
        "largest_force": largest_forces(plan, model),
        "step_size": _euler_step(plan, model),
    }
    return fmu.export(model, path, plan.excited.force_patterns, **options)


def largest_forces(plan: ModesPlan, model: Model) -> dict[str, float]:
    """Return the largest magnitudes of the force inputs at which the scene stays in the table.

    All forces of the scene grow by one factor, found to 1 %, until an amplitude leaves the table.
    Inputs that the scene does not force are omitted, and all of them if no factor up to 1024 takes
    an amplitude out of the table.
    """
    names = [f"force_{mode}" for mode in plan.excited.modes]
    forces = np.abs(plan.schedule.extremes(names)).max(axis=0)
    factor, most = 1.0, 1024.0
    while factor < most and _stays(plan, model, 2.0 * factor):
        factor *= 2.0
    if factor >= most:
        return {}
    step = factor
    for _ in range(7):  # to 1 %
        step *= 0.5
        if _stays(plan, model, factor + step):
            factor += step
    largest = zip(names, (factor * forces).tolist(), strict=True)
    return {name: force for name, force in largest if force > 0.0}


def _stays(plan: ModesPlan, model: Model, factor: float) -> bool:
    """Return whether the scene with `factor` times its forces stays in the table."""
    scripts = {
        name: script.scaled(factor) if name.startswith("force_") else script
        for name, script in plan.schedule.scripts.items()
    }
    schedule = replace(plan.schedule, scripts=scripts)
    excited = plan.excited.started(schedule)
    steps = shortened(schedule, model, excited.modes)
    try:
        return excited.follow(model, steps, plan.scene.run.tolerance).stop is None
    except SlipmodeError:  # it starts outside
        return False


def _euler_step(plan: ModesPlan, model: Model) -> float:
    """Return the scene's step, or a whole part of it, at which explicit Euler is accurate [s].

    FMUs declare it for importers that integrate Model Exchange with fixed steps. A step h takes
    h |lambda|^2 / 2 off the decay -Re lambda of a free vibration with eigenvalue lambda of the
    slow flow: at most 5 % at all nodes of the friction table, under the least, middle and largest
    frequencies of the scene.
    """
    # Part of a decay by which Euler may be wrong, and the least ratio of Re to modulus of an
    # eigenvalue whose decay it follows: amplitudes are within 5 % (tests/fmu/test_scene_fmu.py)
    allowed, least_damped = 0.05, 0.01
    nodes = [model.table.node_a, model.table.node_b][: model.modes]
    points = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, model.modes)
    least, most = plan.schedule.frequency_range(plan.excited.modes)
    longest = plan.scene.run.step
    for frequency in product(*zip(least, 0.5 * (least + most), most, strict=True)):
        flow = ForcedFlow.of(model, np.tile(frequency, (len(points), 1)))
        _, jacobian = flow.rate_and_jacobian(points.astype(complex))
        eigenvalue = np.linalg.eigvals(jacobian[np.isfinite(jacobian).all(axis=(1, 2))])
        size = np.abs(eigenvalue)
        decay = np.maximum(np.abs(eigenvalue.real), least_damped * size)
        longest = min(longest, float(np.min(2.0 * allowed * decay / size**2)))
    return plan.scene.run.step / ceil(plan.scene.run.step / longest * (1.0 - 1e-9))
