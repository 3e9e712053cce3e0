"""Reading a scene file: values as declared in keys.py, and the rules that link several keys."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
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
from slipmode.runner.scene.contacts import (
    STAND_IN,
    read_contacts,
    read_friction,
    read_preload,
)
from slipmode.runner.scene.keys import SCENE
from slipmode.runner.scene.saved_model import options_of, read_saved_model
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import (
    Forcing,
    Log,
    ModelOptions,
    Modes,
    NodeDof,
    Output,
    Run,
    Scene,
    Window,
)
from slipmode.runner.scene.structures import (
    LumpedDisk,
    SectorFile,
    read_mistuning,
    read_structure,
)
from slipmode.runner.scene.toml_table import Table

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


def read_scene(content: Mapping[str, Any], folder: str | PathLike[str], text: str = "") -> Scene:
    """Return the scene of parsed TOML; see `parse_scene`."""
    root = Table(content, SCENE)
    tables: dict[str, Any] = {section.name: root[section.name] for section in SCENE.sections}
    folder = Path(folder)
    saved = read_saved_model(root, folder)
    mistuned = "mistuning" in root
    if saved is not None:
        modes = _saved_modes(saved)
    else:  # a mistuned disk has all modes, and one force, [forcing.A]
        modes = Modes(0) if mistuned else _modes(tables["modes"])
    run = _run(tables["run"])
    units = Units(**tables["units"].values())
    forcing = _forcing(tables["forcing"], modes, run.duration, units)
    initial, aerodynamics = (
        {mode: complex(*table[mode]) for mode in _present_modes(table, modes)}
        for table in (tables["initial"], tables["aerodynamics"])
    )
    if not forcing and not any(initial.values()):
        raise root.error("forcing", "no mode moves; give A, B or an initial amplitude")
    contact, elastic = _windows(tables["contact"], tables["elastic"], run.duration)
    if "friction" in root and tables["contacts"]:
        one = f"are elastic and [friction] is rigid; give one of them. {STAND_IN}"
        raise root.error("contacts", one)
    if not ("friction" in root or tables["contacts"] or saved):
        raise root.error("friction", "is missing; give [friction] or [[contacts]]")
    laws = read_contacts(tables["contacts"])
    if saved is None:
        model = _model(tables["model"], modes, bool(laws), bool(aerodynamics))
    else:
        model = options_of(saved)
    structure = read_structure(tables["structure"], folder) if saved is None else None
    mistuning: tuple[float, ...] = ()
    if isinstance(structure, LumpedDisk | SectorFile):
        if modes.tones:
            raise tables["modes"].error("A", "and B must be one mode with structure.sectors")
        _check_disk(root, model)
        if mistuned:
            _check_mistuned(root, forcing)
            mistuning = read_mistuning(tables["mistuning"], structure.sectors)
        else:
            modes = _of_disk(tables["modes"], structure.sectors, modes, forcing)
    elif mistuned:
        raise root.error("mistuning", "must be left out, because structure has no sectors")
    elif modes.nodal_diameters is not None:
        reason = "must be left out, because structure has no sectors"
        raise tables["modes"].error("nodal_diameters", reason)
    elif modes.tones:
        _check_shared_tone(root, modes, model)
    elif modes.A == modes.B:
        raise tables["modes"].error("B", "must be another mode than A")
    limit_scale = tables["limits"]["scale"]
    if limit_scale is not None:
        fixed = "with limits.scale; full order has fixed limits"
        if model.transients == "hybrid":
            raise tables["model"].error("transients", f'must be "auto" or "slow" {fixed}')
        if model.table == "none":
            raise tables["model"].error("table", f'must be "whole" {fixed}')
    return Scene(
        title=root["title"],
        structure=structure,
        mistuning=mistuning,
        saved_model=saved,
        friction=read_friction(tables["friction"]) if "friction" in root else None,
        contacts=laws,
        preload=read_preload(tables["preload"], laws, folder) if "preload" in root else None,
        limit_scale=limit_scale,
        modes=modes,
        forcing=forcing,
        initial=initial,
        aerodynamics=aerodynamics,
        run=run,
        model=model,
        contact=contact,
        elastic=elastic,
        output=_output(tables["output"], contact, elastic),
        log=Log(**tables["log"].values()),
        text=text,
        units=units,
    )


def _modes(table: Table) -> Modes:
    """Read the section [modes]; several modes share a tone."""
    values, tones = table.values(), list[tuple[int, ...]]()
    for name in MODES:
        numbers = values[name]
        if numbers is None:
            continue
        tones.append(numbers if isinstance(numbers, tuple) else (numbers,))
        if not tones[-1] or len(set(tones[-1])) < len(tones[-1]):
            raise table.error(name, "must be one mode or several different ones")
        values[name] = tones[-1][0]
    shared = any(len(each) > 1 for each in tones)
    if shared and len({*sum(tones, ())}) < len(sum(tones, ())):
        raise table.error("B", "must be other modes than A")
    modes = Modes(**values, tones=tuple(tones) if shared else ())
    if modes.ratio is None:
        return modes
    if shared:
        raise table.error("ratio", "must be left out, because several modes share a tone")
    with naming("modes"):
        return replace(modes, ratio=checked_ratio(float(modes.ratio), len(modes.numbers)))


def _saved_modes(model: Model) -> Modes:
    first, *second = model.reduced.modes
    given = model.reduced.ratio
    ratio = checked_ratio(given, model.modes) if given else None
    return Modes(first, second[0] if second else None, ratio)


def _check_disk(root: Table, model: ModelOptions) -> None:
    """Refuse what scenes with sectors do not have."""
    _check_elastic(root, model, "with structure.sectors")
    if "aerodynamics" in root:
        raise root.error("aerodynamics", "must be left out with structure.sectors")


def _check_elastic(root: Table, model: ModelOptions, where: str) -> None:
    """Refuse what scenes with sectors and those with several modes on one tone do not have."""
    if "friction" in root:
        raise root.error("friction", f"{where} contacts are elastic, [[contacts]]; {STAND_IN}")
    for name in ("preload", "limits"):
        if name in root:
            raise root.error(name, f"must be left out {where}")
    kept_out = {
        "table": (model.table == "none", 'must be "whole"'),
        "transients": (model.transients == "hybrid", 'must be "auto" or "slow"'),
        "budget": (model.budget is not None, "must be left out"),
    }
    for key, (given, instead) in kept_out.items():
        if given:
            raise root["model"].error(key, f"{instead} {where}")


def _check_shared_tone(root: Table, modes: Modes, model: ModelOptions) -> None:
    """Refuse what scenes with several modes on one tone do not have."""
    where = "with several modes on a tone"
    _check_elastic(root, model, where)
    for name in ("aerodynamics", "initial"):
        if name in root:
            raise root.error(name, f"must be left out {where}")
    for key in ("amplitude", "formulation"):
        if key in root["model"]:
            raise root["model"].error(key, f"must be left out {where}")
    for name in modes.numbers:
        if name not in root["forcing"]:
            raise root["forcing"].error(name, f"is missing; {where} each tone has a force")


def _check_mistuned(root: Table, forcing: Mapping[str, Forcing]) -> None:
    """Refuse what scenes of mistuned disks do not have."""
    kept_out = {
        "modes": "all modes of a mistuned disk respond",
        "model": "a mistuned disk has no friction table over amplitudes of modes",
        "initial": "a mistuned disk starts from rest",
        "contact": "a mistuned disk has [[elastic]] windows, which have the contact states",
    }
    for name, reason in kept_out.items():
        if name in root:
            raise root.error(name, f"must be left out, because {reason}")
    if forcing["A"].engine_order is None:
        needed = "is missing; it says how the force travels around the mistuned disk"
        raise root["forcing"]["A"].error("engine_order", needed)
    if "phase" in root["forcing"]["A"]:
        raise root["forcing"]["A"].error(
            "phase", "must be left out, because a mistuned disk has phase 0"
        )
    output = root["output"]
    if len(output["elastic"]) + len(output["nodes"]) > 1:
        raise output.error("elastic", "must be one DOF, which is recorded of every blade")


def _of_disk(table: Table, sectors: int, modes: Modes, forcing: Mapping[str, Forcing]) -> Modes:
    """Return the modes with their nodal diameters, which the engine orders must excite."""
    orders = {mode: each.engine_order for mode, each in forcing.items()}
    excited = {mode: excited_diameter(order, sectors) for mode, order in orders.items() if order}
    given, names = modes.nodal_diameters, list(modes.numbers)
    if given is None:
        for mode in names:
            if mode not in excited:
                raise table.error(
                    "nodal_diameters", f"is missing, and no engine order gives it for mode {mode}"
                )
        given = tuple(excited[mode] for mode in names)
    if len(given) != len(names):
        raise table.error("nodal_diameters", f"must be {len(names)}, one per mode")
    for mode, k in zip(names, given, strict=True):
        if abs(k) > sectors // 2:
            most = sectors // 2
            raise table.error(
                "nodal_diameters", f"must be -{most} to {most} of {sectors} sectors, got {k}"
            )
        if excited.get(mode, k) % sectors != k % sectors:
            raise SlipmodeError(
                f"forcing.{mode}.engine_order = {orders[mode]}: excites nodal diameter "
                f"{excited[mode]} of {sectors} sectors, but modes.nodal_diameters is {k} for mode "
                f"{mode}; engine orders {k % sectors or sectors}, "
                f"{k % sectors + sectors * (1 + (k % sectors == 0))}, ... excite {k}"
            )
    if len(names) == 2 and (modes.A, abs(given[0])) == (modes.B, abs(given[1])):
        raise table.error(
            "B",
            "must be another mode than A, or of another nodal diameter than "
            f"{given[0]} and {-given[0]}, which have equal frequencies",
        )
    return replace(modes, nodal_diameters=given)


def _present_modes(table: Table, modes: Modes) -> list[str]:
    """Return the modes that have a key in a table; refuse one that is not retained."""
    if "B" in table and modes.B is None:
        raise table.error("B", "must be left out, because [modes] or model.file has only mode A")
    return [mode for mode in MODES if mode in table]


def _forcing(table: Table, modes: Modes, duration: float, units: Units) -> dict[str, Forcing]:
    present = _present_modes(table, modes)
    if "B" in present and modes.ratio is not None:
        raise table.error("B", "must be left out, because mode B follows mode A (modes.ratio)")
    forcing = {mode: _forcing_of(mode, table[mode], units) for mode in present}
    for mode, each in forcing.items():
        if each.quadrature is not None and not modes.tones:
            reason = "needs several modes on a tone; the motion of one mode does not rotate"
            raise table[mode].error("quadrature", reason)
    if len(forcing) == 2 and _frequencies_meet(forcing["A"], forcing["B"], duration):
        raise SlipmodeError(meeting_refusal("forcing.A.frequency, forcing.B.frequency"))
    return forcing


def _forcing_of(mode: str, table: Table, units: Units) -> Forcing:
    table.exactly_one(
        ("dof", "node", "vector"), "dof", "give exactly one of dof and vector (or node, direction)"
    )
    if "direction" in table and "node" not in table:
        raise table.error("direction", "needs node, which is missing")
    if "node" in table:
        pattern = NodeDof(table["node"], table.required("direction"))
    else:
        pattern = table["dof"] if "dof" in table else table["vector"]
    given, order, speed = (table[key] for key in ("frequency", "engine_order", "rotor_speed"))
    if order is None:
        if speed is not None:
            raise table.error("rotor_speed", "needs engine_order, which is missing")
        frequency = table.required("frequency").scaled(units.per_frequency)
    elif given is not None:
        raise table.error("frequency", "must be left out; it is engine_order times rotor_speed")
    else:
        frequency = table.required("rotor_speed").scaled(order * RPM)
    amplitude, phase, later = (table[key] for key in ("amplitude", "phase", "quadrature"))
    return Forcing(mode, pattern, amplitude, frequency, phase, order, later)


def _frequencies_meet(A: Forcing, B: Forcing, duration: float) -> bool:
    """Return whether the frequencies, linear between the breakpoints of both, ever meet."""
    if len(A.frequency.times) == len(B.frequency.times) == 1:  # as in most samples of a study
        return A.frequency.values == B.frequency.values
    scripts = {"frequency_A": A.frequency, "frequency_B": B.frequency}
    reached = Schedule(scripts, duration, duration).frequencies(("A", "B"))
    return bool(carriers_meet(np.vstack(reached)))


def _run(table: Table) -> Run:
    run = Run(**table.values())
    if run.step > run.duration:
        most = f"run.duration = {run.duration:g}"
        raise table.error("step", f"must be at most {most}, got {run.step:g}")
    if run.duration > _LARGEST_STEP_COUNT * run.step:
        least = run.duration / _LARGEST_STEP_COUNT
        raise table.error("step", f"must be at least run.duration / 1e7 = {least:g}")
    return run


def _model(table: Table, modes: Modes, elastic: bool, aeroelastic: bool) -> ModelOptions:
    values = table.values()
    del values["file"]
    model = ModelOptions(**values)
    paper, integrated = model.formulation == "paper", model.table == "none"
    slow_only = 'must be "auto" or "slow" with model.formulation = "paper"'
    conflicts = [
        (paper and elastic, "formulation", 'must be "consistent" with [[contacts]]'),
        (paper and aeroelastic, "formulation", 'must be "consistent" with [aerodynamics]'),
        (paper and integrated, "table", 'must be "whole" with model.formulation = "paper"'),
        (paper and model.transients == "hybrid", "transients", slow_only),
    ]
    leave_out = 'must be left out, because model.table = "none" integrates the scene'
    unused = ("amplitude", "transients", "budget")
    conflicts += [(integrated and key in table, key, leave_out) for key in unused]
    n_modes = len(modes.numbers)
    if model.amplitude is not None:
        count = f"must be a list of {n_modes} numbers, got {len(model.amplitude)}"
        conflicts.append((len(model.amplitude) != n_modes, "amplitude", count))
    for applies, key, message in conflicts:
        if applies:
            raise table.error(key, message)
    return model


def _windows(
    contact: list[Table], elastic: list[Table], duration: float
) -> tuple[tuple[Window, ...], tuple[Window, ...]]:
    """Return both kinds of windows in time order; contact windows have the elastic motion too."""
    found = []
    for name, tables in (("contact", contact), ("elastic", elastic)):
        for table in tables:
            start, end = table["window"]
            if not start < end <= duration:
                allowed = f"[t0, t1] with t0 < t1 <= run.duration = {duration:g}"
                raise table.error("window", f"must be {allowed}, got [{start:g}, {end:g}]")
            found.append((name, Window(start, end, table["samples_per_period"])))
    found.sort(key=lambda entry: entry[1].start)
    for (first, earlier), (second, later) in pairwise(found):
        if later.start < earlier.end:
            names = ", ".join(dict.fromkeys((f"{first}.window", f"{second}.window")))
            both = " and ".join(f"[{each.start:g}, {each.end:g}]" for each in (earlier, later))
            raise SlipmodeError(f"{names}: windows must not overlap, got {both}")
    of_contact = tuple(window for name, window in found if name == "contact")
    return of_contact, tuple(window for name, window in found if name == "elastic")


def _output(table: Table, contact: Sequence[Window], elastic: Sequence[Window]) -> Output:
    dofs, nodes = table["elastic"], tuple(NodeDof(*row) for row in table["nodes"])
    if len(set(dofs)) < len(dofs):
        raise table.error("elastic", "DOFs must be distinct")
    if (dofs or nodes) and not (contact or elastic):
        key = "elastic" if dofs else "nodes"
        raise table.error(
            key, "needs an [[elastic]] or [[contact]] window, in which DOFs are reconstructed"
        )
    if elastic and not (dofs or nodes):
        raise SlipmodeError("elastic.window: needs output.elastic, the DOFs to reconstruct")
    return Output(dofs, nodes)
