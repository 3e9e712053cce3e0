"""A scene as one HTML file: its component in a browser, with sliders for the inputs."""

from __future__ import annotations

import webbrowser
from math import isfinite, pi
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.fmu.archive import browser_files, browser_module
from slipmode.fmu.description import ExportOptions
from slipmode.fmu.variables import Variable, list_variables
from slipmode.rom import Model, SlipmodeError
from slipmode.rom.common import warn
from slipmode.rom.laws import contact_directions, is_homogeneous
from slipmode.runner import Scene, load_scene, make_plan
from slipmode.runner.explore.inputs import page_inputs
from slipmode.runner.explore.page_file import write_page
from slipmode.runner.plan import ModesPlan
from slipmode.runner.view import PLOTS, units_of

# Range of the friction table relative to the scene's; limits may fall to a quarter
HEADROOM, SCALED = 2.0, 4.0
_SECONDS = 10.0  # in which the page passes through the duration of the scene


def explore(
    scene: Scene | str | PathLike[str],
    output: str | PathLike[str] | None = None,
    *,
    headroom: float | None = None,
    show: bool = False,
    progress: bool = False,
) -> Path:
    """Write a scene as an HTML file in which forces and friction limits can be changed.

    The file contains the model and the C core as WebAssembly. It runs in a browser without
    installation, server or network. It shows amplitudes in slow time, response curves with their
    stability, and the motion of contacts and DOFs over a beat. The model computes in slow time
    only. A warning in the file states if the estimated transient error of the scene is too large.

    Parameters
    ----------
    scene : Scene, path or str
        Scene, TOML file, or name of a shipped scene, with a friction table of one or two modes or
        waves. Mistuned disks are not allowed.
    output : path, optional
        Name of the file. Default: name of the scene with .html, in the present folder.
    headroom : float, optional
        Margin of the friction table: its range relative to the range that the scene needs [-], >=
        1. It is reduced if the contact motion does not converge at the largest amplitudes.
        Default: 2, or 4 if friction limits can be scaled. A saved model keeps its range.
    show : bool, default False
        Open the file in a browser.
    progress : bool, default False
        Show progress bars if the computation takes longer than 1 s.

    Returns
    -------
    Path
        The HTML file.

    Raises
    ------
    SlipmodeError
        If the scene has no friction table, or the package ziglang, which compiles the core, is not
        installed (`slipmode[explore]`).
    """
    if headroom is not None and not (isfinite(headroom) and headroom >= 1.0):
        raise SlipmodeError(f"range: must be a finite number >= 1, got {headroom:g}")
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    scene.check_tabulated()
    if scene.modes.ratio is not None:
        raise SlipmodeError(
            "modes.ratio: a page needs a tone for each mode; use slipmode run or slipmode curve"
        )
    module = browser_module()
    plan = make_plan(scene.in_slow_time(), progress=progress)
    warn(each for each in plan.decisions if each.subject == "transients")
    if headroom is None:
        is_scaled = is_homogeneous(plan.excited.law, plan.excited.reduced.n_contacts)
        headroom = SCALED if is_scaled else HEADROOM
    model = _model(plan, headroom, progress)
    options = page_options(plan)
    variables = list_variables(model, True, options)
    path = Path(output or f"{scene.name}.html")
    files = browser_files(model, plan.excited.force_patterns, options, variables)
    write_page(path, _content(plan, model, options, variables), module, files)
    if show:
        webbrowser.open(path.resolve().as_uri())
    return path


def _model(plan: ModesPlan, headroom: float, progress: bool) -> Model:
    """Return the model with the largest range up to `headroom` in which the contacts settle."""
    consistent = plan.excited.reduced.formulation == "consistent"
    while True:
        try:
            found, _ = plan.model(
                contact=_shows_motion(plan),
                headroom=headroom,
                detuning=consistent and plan.scene.disk is None,
                progress=progress,
            )
            return found
        except SlipmodeError:
            if headroom == 1.0:
                raise
            headroom = max(1.0, 0.5 * headroom)


def _shows_motion(plan: ModesPlan) -> bool:
    """Return whether motion can be computed: a saved model must keep the harmonics of contacts."""
    saved = plan.scene.saved_model
    return saved is None or saved.harmonics is not None or saved.reduced.formulation == "paper"


def page_options(plan: ModesPlan) -> ExportOptions:
    """Return what a page computes: it starts from rest with the inputs at the end of the scene."""
    excited, schedule = plan.excited, plan.schedule
    contact = _shows_motion(plan)
    elastic = tuple(plan.scene.output.elastic) if contact else ()
    if contact and not elastic:  # where the forces are largest
        forced = (np.abs(each) for each in excited.force_patterns if each.any())
        elastic = tuple(dict.fromkeys(int(each.argmax()) for each in forced))
    held = [name for name in schedule.scripted if "_rate" not in name]  # no sweep goes on
    inputs = schedule.at_ends(held, slice(-1, None))[0]
    return ExportOptions(
        contact=contact,
        elastic=elastic,
        mode_names=excited.modes,
        tolerance=plan.scene.run.tolerance,
        start=dict(zip(held, inputs.tolist(), strict=True)) | excited.start(),
    )


def _content(
    plan: ModesPlan, model: Model, options: ExportOptions, variables: list[Variable]
) -> dict[str, Any]:
    """Return what the page shows, and where it finds the values."""
    scene, modes, named = plan.scene, plan.excited.modes, {v.name: v for v in variables}
    reference = {v.name: k for k, v in enumerate(variables) if v.size is None}
    moved = plan.excited.moved(plan.amplitude)
    units = units_of(scene.text, 2.0 * max(m.shape * m.amplitude for m in moved.values()))
    inputs = page_inputs(plan, model, units, {name: named[name].start for name in options.start})
    wanted = [f"{mode}_{part}" for mode in modes for part in ("re", "im", "abs")]
    wanted = ["time", *wanted, *(each["name"] for each in inputs), "dissipated_power"]
    cycle = 2.0 * pi / float(model.reduced.frequency.min())  # of the slower mode [s]
    speed = float(f"{scene.run.duration / cycle / _SECONDS:.1g}")
    length, titles = 1.0 / float(units.of_displacement(1.0)), {p.name: p.title for p in PLOTS}
    return {
        "title": scene.title or scene.name,
        "name": scene.name,
        "modes": modes,
        "inputs": [each | {"reference": reference[each["name"]]} for each in inputs],
        "recorded": [
            {"name": name, "reference": reference[name], "unit": _unit(named[name])}
            for name in wanted
        ],
        "samples": None
        if model.samples is None
        else {"count": len(model.samples), "reference": reference["sample"]},
        "contacts": _contacts(model, named) if options.contact else [],
        "dofs": [{"name": f"DOF {k}", "slot": named[f"x_{k}"].slot} for k in options.elastic],
        "frequency": {"unit": units.frequency, "per": units.per_frequency},
        "displacement": {"unit": units.displacement, "per": length},
        "amplitudes": [
            {
                "name": titles["A"],
                "labels": [f"{mode} at DOF {each.dof}" for mode, each in moved.items()],
                "unit": units.displacement,
                "per": [length / (2.0 * each.shape) for each in moved.values()],
            },
            {
                "name": titles["amplitude_A"],
                "labels": [f"|{mode}|" for mode in modes],
                "unit": "√kg m",
                "per": [1.0] * len(modes),
            },
        ],
        "cycle": cycle,
        "speed": min(max(speed, 1.0), 1e4),
    }


def _unit(variable: Variable) -> str:
    return variable.quantity.unit if variable.quantity is not None else "1"


def _contacts(model: Model, named: dict[str, Variable]) -> list[dict[str, Any]]:
    """Return names of the contact DOFs, and where their motion is among the outputs."""
    directions = contact_directions(model.law, model.reduced.n_contacts)
    return [
        {
            "name": f"DOF {k}, {each.words}",
            "x": named[f"contact_{k}_x"].slot,
            "f": named[f"contact_{k}_f"].slot,
        }
        for k, each in enumerate(directions)
    ]
