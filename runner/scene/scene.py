"""Reading a scene file: values as declared in keys.py, and the rules that link several keys."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from operator import attrgetter
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom import Model, excited_diameter
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.frequencies import RPM
from slipmode.rom.reduction.tones import checked_ratio
from slipmode.rom.slow.units import Units
from slipmode.rom.storage.files import as_path
from slipmode.rom.storage.text import read_text
from slipmode.rom.validity import carriers_meet, meeting_refusal
from slipmode.runner.recording.channels import MODES
from slipmode.runner.scene.contacts import read_contacts, read_friction, read_preload
from slipmode.runner.scene.keys import (
    SCENE,
    Forcings,
    ForcingTable,
    ModelOptions,
    ModesTable,
    NodeDof,
    Run,
    SceneFile,
    Window,
)
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.sections import Forcing, Modes, Scene
from slipmode.runner.scene.structure_keys import STAND_IN
from slipmode.runner.scene.structures import (
    options_of,
    read_mistuning,
    read_saved_model,
    read_structure,
)
from slipmode.runner.scene.toml_table import (
    Content,
    exactly_one,
    get,
    refuse_given,
    refuse_if,
    required,
)

__all__ = ["Scene", "Window", "load_scene", "parse_scene", "read_scene", "shipped_scenes"]

# Steps are numbered in 64-bit integers and kept one by one in recordings: some GB at this count.
_LARGEST_STEP_COUNT = 1e7


def shipped_scenes() -> dict[str, Path]:
    """Return the scenes that are installed with slipmode.

    Returns
    -------
    dict of str to Path
        TOML file of each scene, by name.
    """
    folder = Path(__file__).parents[1] / "scenes"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_scene(scene: str | PathLike[str]) -> Scene:
    """Return a scene from a TOML file, or a shipped scene.

    Parameters
    ----------
    scene : path or str
        TOML file, or the name of a shipped scene, see `runner.shipped_scenes`.

    Returns
    -------
    Scene
        Checked scene.

    Raises
    ------
    SlipmodeError
        If the file cannot be read, or a key is refused. The message names the file and the key.

    Examples
    --------
    >>> scene = runner.load_scene("sweep")
    >>> scene.run.duration
    6000.0
    """
    path = as_path("scene", scene)
    if not os.path.isfile(path):  # noqa: PTH113  # Path.is_file raises for impossible names
        shipped = shipped_scenes()
        if str(scene) not in shipped:
            raise SlipmodeError(
                f"{str(scene)!r}: no such scene file; shipped scenes: {', '.join(shipped)}"
            )
        path = shipped[str(scene)]
    text = read_text(path, only_unicode=True)
    with naming(path):
        parsed = parse_scene(text, path.parent)
    return replace(parsed, path=path, name=path.stem)


def parse_scene(text: str, folder: str | PathLike[str]) -> Scene:
    """Read a scene from text.

    Parameters
    ----------
    text : str
        TOML with the keys of a scene.
    folder : path
        File names in the scene are relative to it.

    Raises
    ------
    SlipmodeError
        Names the key that is refused and what is allowed.
    """
    return read_scene(parse_toml(text), folder, text)


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of TOML text; a SlipmodeError names the syntax error."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SlipmodeError(f"TOML syntax: {' '.join(str(error).split())}") from error


def read_scene(content: Content, folder: str | PathLike[str], text: str = "") -> Scene:
    """Return the scene of parsed TOML; see `parse_scene`."""
    file: SceneFile = SCENE.read(content)
    run, units = file.run, file.units
    folder = Path(folder)
    saved = read_saved_model(file.model.file, content, folder)
    if saved is not None:
        modes = _saved_modes(saved)
    else:  # a mistuned disk has all modes, and one force, [forcing.A]
        modes = Modes(0) if file.mistuning else _modes(required("modes.A", file.modes))
    _check_run(run)
    forcing = _forcing(file.forcing, modes, run.duration, units)
    initial = _by_mode("initial", file.initial, modes)
    aerodynamics = _by_mode("aerodynamics", file.aerodynamics, modes)
    coefficients = {k: v for k, v in vars(file.nonlinear_stiffness).items() if v is not None}
    if coefficients:
        _check_nonlinear(file.model, content, modes)
    moving = bool(forcing) or any(initial.values())
    refuse_if(not moving, "forcing: no mode moves; give A, B or an initial amplitude")
    _check_windows(file)
    rigid, elastic = file.friction is not None, bool(file.contacts)
    both = f"are elastic and [friction] is rigid; give one of them. {STAND_IN}"
    refuse_if(rigid and elastic, f"contacts: {both}")
    neither = not (rigid or elastic or saved)
    refuse_if(neither, "friction: is missing; give [friction] or [[contacts]]")
    laws = read_contacts(file.contacts, content)
    structure = None
    if saved is not None:
        model = options_of(saved)
    else:
        model = file.model
        _check_model(model, content, modes)
        structure = read_structure(file.structure, content, folder)
    mistuning: tuple[float, ...] = ()
    if structure is not None and structure.sectors:
        refuse_if(bool(modes.tones), "modes.A: and B must be one mode with structure.sectors")
        _check_elastic(content, model, "with structure.sectors")
        if file.mistuning:
            _check_mistuned(content, file)
            mistuning = read_mistuning(file.mistuning, content, structure.sectors)
        else:
            modes = _of_disk(structure.sectors, modes, forcing)
    else:
        no_sectors = "must be left out, because structure has no sectors"
        refuse_given(content, "", ("mistuning",), no_sectors)
        refuse_given(content, "modes", ("nodal_diameters",), no_sectors)
        if modes.tones:
            _check_shared_tone(content, modes, model)
        refuse_if(modes.A == modes.B, "modes.B: must be another mode than A")
    limits = file.limits
    for key, given in (("scale", limits.scale is not None), ("wear", limits.wear > 0.0)):
        if given:
            _check_slow_time(model, f"with limits.{key}; full order has fixed limits")
    return Scene(
        title=file.title,
        structure=structure,
        mistuning=mistuning,
        saved_model=saved,
        friction=None if file.friction is None else read_friction(file.friction),
        contacts=laws,
        preload=None if file.preload is None else read_preload(file.preload, laws, folder),
        limit_scale=limits.scale or (Script.constant(1.0) if limits.wear else None),
        wear=limits.wear,
        modes=modes,
        forcing=forcing,
        initial=initial,
        aerodynamics=aerodynamics,
        nonlinear_stiffness=coefficients,
        run=run,
        model=model,
        contact=tuple(sorted(file.contact, key=attrgetter("start"))),
        elastic=tuple(sorted(file.elastic, key=attrgetter("start"))),
        output=file.output,
        log=file.log,
        text=text,
        units=units,
    )


def _modes(keys: ModesTable) -> Modes:
    """Read the section [modes]; several modes share a tone."""
    tones: list[tuple[int, ...]] = []
    for name, given in (("A", keys.A), ("B", keys.B)):
        if given is not None:
            tones.append(given if isinstance(given, tuple) else (given,))
            different = len(set(tones[-1])) == len(tones[-1]) > 0
            refuse_if(not different, f"modes.{name}: must be one mode or several different ones")
    shared, every = any(len(each) > 1 for each in tones), sum(tones, ())
    refuse_if(shared and len(set(every)) < len(every), "modes.B: must be other modes than A")
    first, *second = (each[0] for each in tones)
    own = tuple(tones) if shared else ()
    modes = Modes(first, second[0] if second else None, None, keys.nodal_diameters, own)
    if keys.ratio is None:
        return modes
    refuse_if(shared, "modes.ratio: must be left out, because several modes share a tone")
    with naming("modes"):
        return replace(modes, ratio=checked_ratio(keys.ratio, len(modes.numbers)))


def _saved_modes(model: Model) -> Modes:
    first, *second = model.reduced.modes
    given = model.reduced.ratio
    ratio = checked_ratio(given, model.modes) if given else None
    return Modes(first, second[0] if second else None, ratio)


def _check_slow_time(model: ModelOptions, where: str) -> None:
    """Refuse full order."""
    refuse_if(model.table == "none", f'model.table: must be "whole" {where}')
    hybrid = model.transients == "hybrid"
    refuse_if(hybrid, f'model.transients: must be "auto" or "slow" {where}')


def _check_nonlinear(model: ModelOptions, content: Content, modes: Modes) -> None:
    """Refuse what scenes with nonlinear stiffness do not have."""
    where = "with [nonlinear_stiffness]"
    _check_slow_time(model, where)
    refuse_if(model.formulation == "paper", f'model.formulation: must be "consistent" {where}')
    refuse_given(content, "modes", ("ratio",), f"must be left out {where}")
    if modes.B is None:
        only_A = "must be left out, because [modes] has only mode A"
        of_B = [name for name in content["nonlinear_stiffness"] if "B" in name]
        refuse_given(content, "nonlinear_stiffness", of_B, only_A)


def _check_elastic(content: Content, model: ModelOptions, where: str) -> None:
    """Refuse what scenes with sectors and those with several modes on one tone do not have."""
    elastic = f"{where} contacts are elastic, [[contacts]]; {STAND_IN}"
    refuse_given(content, "", ("friction",), elastic)
    left_out = ("preload", "limits", "aerodynamics", "nonlinear_stiffness", "model.budget")
    refuse_given(content, "", left_out, f"must be left out {where}")
    _check_slow_time(model, where)


def _check_shared_tone(content: Content, modes: Modes, model: ModelOptions) -> None:
    """Refuse what scenes with several modes on one tone do not have."""
    where = "with several modes on a tone"
    _check_elastic(content, model, where)
    left_out = ("initial", "model.amplitude", "model.formulation")
    refuse_given(content, "", left_out, f"must be left out {where}")
    for name in modes.numbers:
        missing = get(content, f"forcing.{name}") is None
        refuse_if(missing, f"forcing.{name}: is missing; {where} each tone has a force")


def _check_mistuned(content: Content, file: SceneFile) -> None:
    """Refuse what scenes of mistuned disks do not have."""
    left_out = {
        "modes": "all modes of a mistuned disk respond",
        "model": "a mistuned disk has no friction table over amplitudes of modes",
        "initial": "a mistuned disk starts from rest",
        "contact": "a mistuned disk has [[elastic]] windows, which have the contact states",
        "forcing.A.phase": "a mistuned disk has phase 0",
    }
    for name, reason in left_out.items():
        refuse_given(content, "", (name,), f"must be left out, because {reason}")
    assert file.forcing.A is not None  # a scene without an initial amplitude has a force
    needed = "is missing; it says how the force travels around the mistuned disk"
    refuse_if(file.forcing.A.engine_order is None, f"forcing.A.engine_order: {needed}")
    several = len(file.output.elastic) + len(file.output.nodes) > 1
    refuse_if(several, "output.elastic: must be one DOF, which is recorded of every blade")


def _of_disk(sectors: int, modes: Modes, forcing: Mapping[str, Forcing]) -> Modes:
    """Return the modes with their nodal diameters, which the engine orders must excite."""
    key = "modes.nodal_diameters"
    orders = {mode: each.engine_order for mode, each in forcing.items()}
    excited = {mode: excited_diameter(order, sectors) for mode, order in orders.items() if order}
    given, names = modes.nodal_diameters, list(modes.numbers)
    if given is None:
        for mode in names:
            missing = f"is missing, and no engine order gives it for mode {mode}"
            refuse_if(mode not in excited, f"{key}: {missing}")
        given = tuple(excited[mode] for mode in names)
    refuse_if(len(given) != len(names), f"{key}: must be {len(names)}, one per mode")
    most = sectors // 2
    for mode, k in zip(names, given, strict=True):
        allowed = f"{key}: must be -{most} to {most} of {sectors} sectors"
        refuse_if(abs(k) > most, f"{allowed}, got {k}")
        if excited.get(mode, k) % sectors != k % sectors:
            raise SlipmodeError(
                f"forcing.{mode}.engine_order = {orders[mode]}: excites nodal diameter "
                f"{excited[mode]} of {sectors} sectors, but {key} is {k} for mode {mode}; engine "
                f"orders {k % sectors or sectors}, "
                f"{k % sectors + sectors * (1 + (k % sectors == 0))}, ... excite {k}"
            )
    if len(names) == 2 and (modes.A, abs(given[0])) == (modes.B, abs(given[1])):
        raise SlipmodeError(
            "modes.B: must be another mode than A, or of another nodal diameter than "
            f"{given[0]} and {-given[0]}, which have equal frequencies"
        )
    return replace(modes, nodal_diameters=given)


def _by_mode(name: str, table: Any, modes: Modes) -> dict[str, Any]:
    """Return the values of a table by mode; refuse a mode that is not retained."""
    found: dict[str, Any] = {
        mode: value for mode in MODES if (value := getattr(table, mode)) is not None
    }
    only_A = f"{name}.B: must be left out, because [modes] or model.file has only mode A"
    refuse_if("B" in found and modes.B is None, only_A)
    return found


def _forcing(table: Forcings, modes: Modes, duration: float, units: Units) -> dict[str, Forcing]:
    given = _by_mode("forcing", table, modes)
    follows = "forcing.B: must be left out, because mode B follows mode A (modes.ratio)"
    refuse_if("B" in given and modes.ratio is not None, follows)
    forcing = {mode: _forcing_of(mode, keys, units) for mode, keys in given.items()}
    for mode, each in forcing.items():
        if each.quadrature is not None and not modes.tones:
            reason = "needs several modes on a tone; the motion of one mode does not rotate"
            raise SlipmodeError(f"forcing.{mode}.quadrature: {reason}")
    if len(forcing) == 2 and _frequencies_meet(forcing["A"], forcing["B"], duration):
        raise SlipmodeError(meeting_refusal("forcing.A.frequency, forcing.B.frequency"))
    return forcing


def _forcing_of(mode: str, keys: ForcingTable, units: Units) -> Forcing:
    path, patterns = f"forcing.{mode}", (keys.dof, keys.node, keys.vector)
    one = "give exactly one of dof and vector (or node, direction)"
    exactly_one(f"{path}.dof", patterns, one)
    for key, other in (("direction", "node"), ("rotor_speed", "engine_order")):
        alone = getattr(keys, key) is not None and getattr(keys, other) is None
        refuse_if(alone, f"{path}.{key}: needs {other}, which is missing")
    pattern: int | tuple[float, ...] | NodeDof
    if keys.node is not None:
        pattern = NodeDof(keys.node, required(f"{path}.direction", keys.direction))
    else:
        pattern = keys.vector or keys.dof or 0
    order = keys.engine_order
    if order is None:
        frequency = required(f"{path}.frequency", keys.frequency).scaled(units.per_frequency)
    else:
        both = "must be left out; it is engine_order times rotor_speed"
        refuse_if(keys.frequency is not None, f"{path}.frequency: {both}")
        frequency = required(f"{path}.rotor_speed", keys.rotor_speed).scaled(order * RPM)
    return Forcing(mode, pattern, keys.amplitude, frequency, keys.phase, order, keys.quadrature)


def _frequencies_meet(A: Forcing, B: Forcing, duration: float) -> bool:
    """Return whether the frequencies, linear between the breakpoints of both, ever meet."""
    if len(A.frequency.times) == len(B.frequency.times) == 1:  # as in most samples of a study
        return A.frequency.values == B.frequency.values
    scripts = {"frequency_A": A.frequency, "frequency_B": B.frequency}
    reached = Schedule(scripts, duration, duration).frequencies(("A", "B"))
    return bool(carriers_meet(np.vstack(reached)))


def _check_run(run: Run) -> None:
    most = f"run.step: must be at most run.duration = {run.duration:g}"
    refuse_if(run.step > run.duration, f"{most}, got {run.step:g}")
    least = f"run.step: must be at least run.duration / 1e7 = {run.duration / 1e7:g}"
    refuse_if(run.duration > _LARGEST_STEP_COUNT * run.step, least)


def _check_model(model: ModelOptions, content: Content, modes: Modes) -> None:
    if model.formulation == "paper":
        consistent = 'model.formulation: must be "consistent" with'
        refuse_if(bool(content.get("contacts")), f"{consistent} [[contacts]]")
        refuse_if(bool(content.get("aerodynamics")), f"{consistent} [aerodynamics]")
        _check_slow_time(model, 'with model.formulation = "paper"')
    if model.table == "none":
        left_out = 'must be left out, because model.table = "none" integrates the scene'
        refuse_given(content, "model", ("amplitude", "transients", "budget"), left_out)
    n_modes, given = len(modes.numbers), len(model.amplitude or ())
    count = f"model.amplitude: must be a list of {n_modes} numbers, got {given}"
    refuse_if(model.amplitude is not None and given != n_modes, count)


def _check_windows(file: SceneFile) -> None:
    """Refuse windows outside the run or with common times, and DOFs without a window."""
    found, duration = [], file.run.duration
    for name, windows in (("contact", file.contact), ("elastic", file.elastic)):
        for k, window in enumerate(windows):
            allowed = f"[t0, t1] with t0 < t1 <= run.duration = {duration:g}"
            got = f"[{window.start:g}, {window.end:g}]"
            fits = window.start < window.end <= duration
            refuse_if(not fits, f"{name}[{k}].window: must be {allowed}, got {got}")
            found.append((name, window, got))
    found.sort(key=lambda entry: entry[1].start)
    for (first, earlier, got), (second, later, other) in pairwise(found):
        names = ", ".join(dict.fromkeys((f"{first}.window", f"{second}.window")))
        overlap = f"{names}: windows must not overlap, got {got} and {other}"
        refuse_if(later.start < earlier.end, overlap)
    dofs, nodes = file.output.elastic, file.output.nodes
    refuse_if(len(set(dofs)) < len(dofs), "output.elastic: DOFs must be distinct")
    key = "output.elastic" if dofs else "output.nodes"
    needed = "needs an [[elastic]] or [[contact]] window, in which DOFs are reconstructed"
    refuse_if(bool(dofs or nodes) and not found, f"{key}: {needed}")
    no_dofs = bool(file.elastic) and not (dofs or nodes)
    refuse_if(no_dofs, "elastic.window: needs output.elastic, the DOFs to reconstruct")
