"""Reading a scene file (TOML): each reader below is one of its sections."""

import inspect
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any, Literal, cast, get_args

import numpy as np

from slipmode.rom.error_budget import SLOW_FLOW
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.files import as_path
from slipmode.rom.frequencies import FrequencyUnit
from slipmode.rom.slow.units import LengthUnit, Units
from slipmode.rom.structure.damping import Rayleigh
from slipmode.rom.structure.labels import DIRECTIONS
from slipmode.rom.structure.structure import two_mass
from slipmode.rom.validity import carriers_meet, meeting_refusal
from slipmode.runner.recording.channels import MODES
from slipmode.runner.scene.contacts import (
    CONTACTS,
    FRICTION,
    PRELOAD,
    STAND_IN,
    read_contacts,
    read_friction,
    read_preload,
)
from slipmode.runner.scene.nodes import NodeDof, read_nodes
from slipmode.runner.scene.nodes import read_contacts as read_structure_contacts
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.sections import (
    ContactGroup,
    Forcing,
    Log,
    MatrixFile,
    ModelOptions,
    Modes,
    Output,
    RigidFriction,
    Run,
    Scene,
    StaticForce,
    TwoMass,
    Window,
)
from slipmode.runner.scene.toml_table import FINITE, NON_NEGATIVE, POSITIVE, Table, between

__all__ = [
    "ContactGroup",
    "Forcing",
    "Log",
    "MatrixFile",
    "ModelOptions",
    "Modes",
    "Output",
    "RigidFriction",
    "Run",
    "Scene",
    "StaticForce",
    "TwoMass",
    "Window",
    "load_scene",
    "parse_scene",
    "shipped_scenes",
]


_TWO_MASS_PARAMETERS = tuple(
    name for name in inspect.signature(two_mass).parameters if name != "beta"
)
_OF_MATRICES = ("mass", "contacts", "rayleigh")
SECTIONS = {
    "structure": ("model", "matrices", "damping", *_OF_MATRICES, *_TWO_MASS_PARAMETERS),
    "friction": FRICTION,
    "preload": PRELOAD,
    "limits": ("scale",),
    "modes": MODES,
    "forcing": MODES,
    "initial": MODES,
    "aerodynamics": MODES,
    "run": ("duration", "step", "tolerance"),
    "model": ("tolerance", "formulation", "amplitude", "table", "transients", "budget"),
    "output": ("elastic", "nodes"),
    "log": ("mcap", "rerun"),
    "units": ("frequency", "displacement"),
}
FORCING = ("dof", "node", "direction", "vector", "amplitude", "frequency", "phase")
WINDOW = ("window", "samples_per_period")
# [[contact]] and [[contacts]] look alike: whose key it is, and where it goes
_OF_LAWS = dict.fromkeys(CONTACTS, "the laws of contacts are in [[contacts]]")
_OF_WINDOWS = dict.fromkeys(WINDOW, "windows of contact motion are [[contact]]")
_LARGEST_STEP_COUNT = 1e7
_AMPLITUDE = replace(NON_NEGATIVE, text=">= 0 (use phase to turn the force round)")


def shipped_scenes() -> dict[str, Path]:
    """The scenes that come with slipmode, by name."""
    folder = Path(__file__).parents[1] / "scenes"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_scene(scene: str | PathLike[str]) -> Scene:
    """Read a scene from a file, or a shipped scene by its name.

    Parameters
    ----------
    scene : str or path
        Of the TOML file, or a name of `shipped_scenes`.

    Raises
    ------
    SlipmodeError
        Naming the file and the key that is refused.
    """
    path = as_path("scene", scene)
    if not (_exists(path) and path.is_file()):
        shipped = shipped_scenes()
        if str(scene) not in shipped:
            raise SlipmodeError(
                f"{str(scene)!r}: no such scene file; shipped scenes: {', '.join(shipped)}"
            )
        path = shipped[str(scene)]
    try:
        parsed = parse_scene(path.read_text(encoding="utf-8"), path.parent)
    except OSError as error:
        raise SlipmodeError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SlipmodeError(f"{path}: must be UTF-8 text") from error
    except SlipmodeError as error:
        raise SlipmodeError(f"{path}: {error}") from error
    return replace(parsed, path=path, name=path.stem)


def parse_scene(text: str, folder: str | PathLike[str]) -> Scene:
    """Read a scene from TOML text; file names in it are relative to `folder`.

    Raises
    ------
    SlipmodeError
        Naming the key that is refused and what it may be.
    """
    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SlipmodeError(f"TOML syntax: {' '.join(str(error).split())}") from error
    return read_scene(content, folder, text)


def read_scene(content: Mapping[str, Any], folder: str | PathLike[str], text: str = "") -> Scene:
    """The scene of TOML that has been parsed; see `parse_scene`.

    Raises
    ------
    SlipmodeError
    """
    root = Table(content, ("title", "contact", "contacts", "elastic", *SECTIONS))
    section = {name: root.section(name, keys) for name, keys in SECTIONS.items()}
    groups = root.sections("contacts", CONTACTS, _OF_WINDOWS)
    modes = _modes(section["modes"])
    run = _run(section["run"])
    units = _units(section["units"])
    forcing = _forcing(section["forcing"], modes, run.duration, units)
    initial, aerodynamics = (
        _complex(section[name], modes) for name in ("initial", "aerodynamics")
    )
    if not forcing and not any(initial.values()):
        raise root.error("forcing", "nothing moves; give A, B or an initial amplitude")
    contact, elastic = (
        _windows(root.sections(name, WINDOW, _OF_LAWS), run.duration)
        for name in ("contact", "elastic")
    )
    _refuse_overlap(contact, elastic)
    _refuse_mixed_laws(root, groups)
    laws = read_contacts(groups)
    model = _model(section["model"], modes, bool(groups), bool(aerodynamics))
    limit_scale = _limit_scale(section["limits"])
    if limit_scale is not None:
        fixed = "with limits.scale; full order has fixed limits"
        if model.transients == "hybrid":
            raise SlipmodeError(f'model.transients: must be "auto" or "slow" {fixed}')
        if model.table == "none":
            raise SlipmodeError(f'model.table: must be "whole" {fixed}')
    return Scene(
        title=root.text("title", default=""),
        structure=_structure(section["structure"], Path(folder)),
        friction=read_friction(section["friction"]) if "friction" in root else None,
        contacts=laws,
        preload=_preload(section["preload"], laws, Path(folder)) if "preload" in root else None,
        limit_scale=limit_scale,
        modes=modes,
        forcing=forcing,
        initial=initial,
        aerodynamics=aerodynamics,
        run=run,
        model=model,
        contact=contact,
        elastic=elastic,
        output=_output(section["output"], contact, elastic),
        log=_log(section["log"]),
        text=text,
        units=units,
    )


def _structure(table: Table, folder: Path) -> TwoMass | MatrixFile:
    if ("model" in table) == ("matrices" in table):
        raise table.error("model", "give exactly one of model and matrices")
    damping = table.number("damping", NON_NEGATIVE) if "damping" in table else None
    if "model" in table:
        table.choice("model", ("two-mass",))
        for key in _OF_MATRICES:
            if key in table:
                raise table.error(key, 'is for matrices, not for model = "two-mass"')
        parameters = {key: table.number(key) for key in _TWO_MASS_PARAMETERS if key in table}
        return TwoMass(parameters if damping is None else {"beta": damping, **parameters})
    for key in _TWO_MASS_PARAMETERS:
        if key in table:
            raise table.error(key, 'is a parameter of model = "two-mass", not of matrices')
    return MatrixFile(
        _existing(table, "matrices", folder),
        _rayleigh(table) if "rayleigh" in table else damping,
        _existing(table, "mass", folder) if "mass" in table else None,
        read_structure_contacts(table, "contacts"),
    )


def _rayleigh(table: Table) -> Rayleigh:
    if "damping" in table:
        raise table.error("rayleigh", "give one of damping and rayleigh")
    return Rayleigh(*table.numbers("rayleigh", NON_NEGATIVE, 2))


def _existing(table: Table, key: str, folder: Path) -> Path:
    path = folder / table.text(key)
    if not _exists(path):
        raise table.error(key, f"no such file or folder: {str(path)!r}")
    return path


def _exists(path: Path) -> bool:
    """Whether the path exists; it does not if it is no possible name."""
    try:
        path.stat()
    except (OSError, ValueError):
        return False
    return True


def _refuse_mixed_laws(root: Table, groups: list[Table]) -> None:
    """Contacts are either all rigid or all elastic."""
    if "friction" in root and groups:
        raise root.error(
            "contacts", f"are elastic, [friction] is rigid: give one of both; {STAND_IN}"
        )
    if "friction" not in root and not groups:
        raise root.error("friction", "is missing: give [friction] or [[contacts]]")


def _preload(table: Table, laws: tuple[ContactGroup, ...], folder: Path) -> StaticForce:
    return read_preload(table, laws, lambda table, key: _existing(table, key, folder))


def _limit_scale(table: Table) -> Script | None:
    return table.script("scale", POSITIVE) if "scale" in table else None


def _modes(table: Table) -> Modes:
    modes = Modes(A=table.integer("A"), B=table.integer("B") if "B" in table else None)
    if modes.A == modes.B:
        raise table.error("B", "must be another mode than A")
    return modes


def _present_modes(table: Table, modes: Modes) -> list[str]:
    """The modes a table speaks of, each of which must be retained."""
    if "B" in table and modes.B is None:
        raise table.error("B", "there is no mode B in [modes]; allowed: A")
    return [mode for mode in MODES if mode in table]


def _units(table: Table) -> Units:
    return Units(
        cast(FrequencyUnit, table.choice("frequency", get_args(FrequencyUnit), default="rad/s")),
        cast(LengthUnit, table.choice("displacement", get_args(LengthUnit), default="m")),
    )


def _forcing(table: Table, modes: Modes, duration: float, units: Units) -> dict[str, Forcing]:
    forcing = {
        mode: _forcing_of(mode, table.section(mode, FORCING), units)
        for mode in _present_modes(table, modes)
    }
    if len(forcing) == 2 and _frequencies_meet(forcing["A"], forcing["B"], duration):
        raise SlipmodeError(meeting_refusal("forcing.A.frequency, forcing.B.frequency"))
    return forcing


def _forcing_of(mode: str, table: Table, units: Units) -> Forcing:
    if sum(key in table for key in ("dof", "node", "vector")) != 1:
        raise table.error("dof", "give exactly one of dof and vector (or node, direction)")
    if "direction" in table and "node" not in table:
        raise table.error("direction", "is of node, which is missing")
    return Forcing(
        mode=mode,
        pattern=_pattern(table),
        amplitude=table.script("amplitude", _AMPLITUDE),
        frequency=table.script("frequency", POSITIVE).scaled(units.per_frequency),
        phase=table.script("phase", FINITE, default=0.0),
    )


def _pattern(table: Table) -> int | tuple[float, ...] | NodeDof:
    if "dof" in table:
        return table.integer("dof")
    if "node" in table:
        return NodeDof(table.integer("node", FINITE), table.choice("direction", DIRECTIONS))
    return table.numbers("vector")


def _frequencies_meet(A: Forcing, B: Forcing, duration: float) -> bool:
    """Whether the frequencies, linear between the breakpoints of both, ever meet."""
    if len(A.frequency.times) == len(B.frequency.times) == 1:  # as in most samples of a study
        return A.frequency.values == B.frequency.values
    inner = {t for t in (*A.frequency.times, *B.frequency.times) if 0.0 < t < duration}
    starts, ends = np.array([0.0, *sorted(inner)]), np.array([*sorted(inner), duration])
    reached = [
        np.concatenate((each.frequency.value(starts), each.frequency.value_before(ends)))
        for each in (A, B)
    ]
    return bool(carriers_meet(np.stack(reached, axis=-1)))


def _complex(table: Table, modes: Modes) -> dict[str, complex]:
    """[re, im] of the modes it speaks of."""
    return {mode: complex(*table.numbers(mode, length=2)) for mode in _present_modes(table, modes)}


def _run(table: Table) -> Run:
    run = Run(
        duration=table.number("duration", POSITIVE),
        step=table.number("step", POSITIVE),
        tolerance=table.number("tolerance", POSITIVE, default=SLOW_FLOW),
    )
    if run.step > run.duration:
        raise table.error(
            "step", f"must be at most run.duration = {run.duration:g}, got {run.step:g}"
        )
    if run.duration > _LARGEST_STEP_COUNT * run.step:
        least = run.duration / _LARGEST_STEP_COUNT
        raise table.error("step", f"must be at least run.duration / 1e7 = {least:g}")
    return run


def _model(table: Table, modes: Modes, elastic: bool, aeroelastic: bool) -> ModelOptions:
    n_modes = len(modes.numbers)
    formulation = table.choice("formulation", ("consistent", "paper"), default="consistent")
    if elastic and formulation == "paper":
        raise table.error("formulation", 'must be "consistent" with [[contacts]]')
    if aeroelastic and formulation == "paper":
        raise table.error("formulation", 'must be "consistent" with [aerodynamics]')
    extent = table.choice("table", ("whole", "none"), default="whole")
    if extent == "none" and formulation == "paper":
        raise table.error("table", 'must be "whole" with model.formulation = "paper"')
    if extent == "none":
        for key in ("amplitude", "transients", "budget"):
            if key in table:
                raise table.error(key, 'leave it out: model.table = "none" integrates the scene')
    transients = table.choice("transients", ("auto", "slow", "hybrid"), default="auto")
    if transients == "hybrid" and formulation == "paper":
        raise table.error(
            "transients", 'must be "auto" or "slow" with model.formulation = "paper"'
        )
    return ModelOptions(
        tolerance=table.number("tolerance", POSITIVE, default=1e-3),
        formulation=cast(Literal["consistent", "paper"], formulation),
        amplitude=table.numbers("amplitude", POSITIVE, n_modes) if "amplitude" in table else None,
        table=cast(Literal["whole", "none"], extent),
        transients=cast(Literal["auto", "slow", "hybrid"], transients),
        budget=table.number("budget", POSITIVE) if "budget" in table else None,
    )


def _windows(tables: list[Table], duration: float) -> tuple[Window, ...]:
    windows = (_window(table, duration) for table in tables)
    return tuple(sorted(windows, key=lambda window: window.start))


def _window(table: Table, duration: float) -> Window:
    start, end = table.numbers("window", NON_NEGATIVE, length=2)
    if not start < end <= duration:
        raise table.error(
            "window",
            f"must be [t0, t1] with t0 < t1 <= run.duration = {duration:g}, "
            f"got [{start:g}, {end:g}]",
        )
    return Window(start, end, table.integer("samples_per_period", between(8, 4096), 64))


def _refuse_overlap(contact: tuple[Window, ...], elastic: tuple[Window, ...]) -> None:
    """Contact windows have the elastic motion too, so no window may overlap another."""
    named = [("contact", window) for window in contact] + [
        ("elastic", window) for window in elastic
    ]
    named.sort(key=lambda entry: entry[1].start)
    for (first, earlier), (second, later) in pairwise(named):
        if later.start < earlier.end:
            names = f"{first}.window" if first == second else f"{first}.window, {second}.window"
            raise SlipmodeError(
                f"{names}: windows must not overlap, got [{earlier.start:g}, "
                f"{earlier.end:g}] and [{later.start:g}, {later.end:g}]"
            )


def _output(table: Table, contact: tuple[Window, ...], elastic: tuple[Window, ...]) -> Output:
    dofs = table.integers("elastic") if "elastic" in table else ()
    if len(set(dofs)) < len(dofs):
        raise table.error("elastic", "DOFs must be distinct")
    nodes = read_nodes(table, "nodes")
    wanted = "elastic" if dofs else "nodes"
    if (dofs or nodes) and not (contact or elastic):
        raise table.error(wanted, "is reconstructed inside windows; give [[elastic]] window")
    if elastic and not (dofs or nodes):
        raise SlipmodeError("elastic.window: needs output.elastic, the DOFs that are wanted")
    return Output(dofs, nodes)


def _log(table: Table) -> Log:
    return Log(
        mcap=table.boolean("mcap", default=True), rerun=table.boolean("rerun", default=True)
    )
