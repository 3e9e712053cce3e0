"""Every key of a scene file: the only declaration of its kind, unit, default and meaning.

The reader (scene.py), its refusals, the reference in docs/scene_keys.py and the keys of studies
follow from `SCENE`.
"""

from __future__ import annotations

import inspect
import textwrap
from dataclasses import MISSING, fields, replace
from typing import Any, get_args

from slipmode.rom.error_budget import SLOW_FLOW
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import FrequencyUnit
from slipmode.rom.laws.law_record import LAWS
from slipmode.rom.slow.units import LengthUnit
from slipmode.rom.structure.labels import DIRECTIONS
from slipmode.rom.structure.structure import two_mass
from slipmode.runner.recording.channels import MODES
from slipmode.runner.scene.toml_table import Key, Section
from slipmode.runner.scene.values import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    Kind,
    Rule,
    at_least,
    between,
    boolean,
    choice,
    either,
    integer,
    integers,
    node_dofs,
    number,
    numbers,
    one_or_each,
    pairs_of_integers,
    script,
    text,
)

RIGID_LAWS = ("tanh", "coulomb")
ELASTIC_LAWS = {name: law for name, law in LAWS.items() if name not in RIGID_LAWS}


def _two_mass(name: str, meaning: str, unit: str = "N/m") -> Key:
    """Return the key of a parameter of `rom.two_mass`, with the default of that function."""
    default = inspect.signature(two_mass).parameters[name].default
    return Key(name, number(), unit, default, meaning)


def _law(name: str, kind: Kind, unit: str, meaning: str, **role: Any) -> Key:
    """Return the key of a parameter of elastic laws, with the default of these laws."""
    own = [(law, f) for law, cls in ELASTIC_LAWS.items() for f in fields(cls) if f.name == name]
    (default,) = {f.default for _, f in own}
    laws = ", ".join(f"`{law}`" for law, _ in own)
    return Key(name, kind, unit, default, f"{meaning} Of {laws}.", **role)


# fmt: off
# A table: each key in two lines, which formatted code would spread over eight.
CONTACT_KEYS = (
    Key("law", choice(*ELASTIC_LAWS), "-", MISSING, "The law of the contacts of the group."),
    Key("contacts", integers(), "-", None,
        "Their contact DOFs, from 0. A single group may leave it out and has all of them."),
    _law("limit", one_or_each(NON_NEGATIVE), "N",
         "Friction limit mu N; of `sliders` a list.", role="limit"),
    _law("stiffness", one_or_each(POSITIVE), "N/m",
         "Stiffness while the contact sticks; of `sliders` a list, of `iwan` one number."),
    _law("force", number(POSITIVE), "N", "Force of macro-slip.", role="limit"),
    _law("chi", number(), "-", "Exponent of the sliders' density, -1 < chi <= 1."),
    _law("beta", number(NON_NEGATIVE), "-",
         "Stiffness of the sliders that slip at macro-slip, relative to the others."),
    _law("sliders", integer(), "-", "Number of sliders, 2 to 1000."),
    _law("mu", one_or_each(NON_NEGATIVE), "-", "Coefficient of friction."),
    _law("preload", one_or_each(NON_NEGATIVE), "N", "Normal force at rest.", role="limit"),
    _law("tangential_stiffness", one_or_each(POSITIVE), "N/m", "Stiffness while it sticks."),
    _law("normal_stiffness", one_or_each(POSITIVE), "N/m", "Stiffness while it is closed."),
    _law("gap", one_or_each(NON_NEGATIVE), "m",
         "Normal displacement at which the contact closes; 0 if it has a preload."),
    _law("tangents", integer(), "-",
         "Tangential directions of each contact, 1 or 2; its normal DOF follows them."),
)
_WINDOW = (
    Key("window", numbers(NON_NEGATIVE, 2), "s", MISSING,
        "[start, end], up to the scene's duration; start before end."),
    Key("samples_per_period", integer(between(8, 4096)), "-", 64,
        "Samples in a period of the fastest carrier."),
)

SCENE = Section("", "At the top of the file, before any table.", (
    Key("title", text(), "-", "", "The name of recordings and pictures."),
    Section("structure",
        "What vibrates: the model of two masses, with the parameters from `contact_mass` on; "
        "matrices from files; or a bladed disk of equal sectors, which has travelling waves.", (
        Key("model", choice("two-mass", "lumped-disk"), "-", None,
            "The model of Table 1 of the source paper, or the disk of `rom.lumped_disk`. Exactly "
            "one of `model` and `matrices`."),
        Key("matrices", text(), "-", None,
            "File or folder of matrices that `rom.load_structure` reads, relative to the scene; "
            "with `sectors`, of one sector."),
        Key("damping", number(NON_NEGATIVE), "s", None,
            "beta of damping proportional to stiffness, C = beta K. Default: that of "
            "`rom.two_mass` or `rom.lumped_disk`, for matrices the damping in their files."),
        Key("sectors", integer(at_least(3)), "-", None,
            "Number of sectors of a bladed disk. Default: 24 of the lumped disk; matrices with "
            "this key are of one sector."),
        Key("blade_stiffnesses", numbers(POSITIVE, 2), "N/m", None,
            "Of the lumped disk: from the disk to the first blade mass, and between the blade "
            "masses. Default: those of `rom.lumped_disk`."),
        Key("left", integers(), "-", None,
            "DOFs of the sector on one side; all DOFs but `right` are numbered from 0 elsewhere "
            "in the scene."),
        Key("right", integers(), "-", None,
            "DOFs on the other side, in the order in which they meet `left` of the next sector."),
        Key("interface", pairs_of_integers("[left node, right node]"), "-", None,
            "Instead of `left` and `right`, nodes that meet, in all their directions."),
        Key("next_contacts", node_dofs("[contact, node, direction]", (3,)), "-", None,
            "What contacts touch on the next sector: their relative motion is that of the "
            "contact less that of this node."),
        Key("mass", text(), "-", None,
            "File of the mass matrix, if `matrices` has stiffness alone."),
        Key("contacts", node_dofs("[node, direction] or [node, node, direction]", (2, 3)), "-",
            None,
            "Contact DOFs by node; of two nodes: their relative motion. Overrides the file's."),
        Key("rayleigh", numbers(NON_NEGATIVE, 2), "1/s, s", None,
            "[alpha, beta] of C = alpha M + beta K, instead of `damping`."),
        _two_mass("contact_mass", "Mass of each contact DOF, > 0.", "kg"),
        _two_mass("m1", "First modal mass, > 0.", "kg"),
        _two_mass("m2", "Second modal mass, > 0.", "kg"),
        _two_mass("k1", "First mass to its contact DOF."),
        _two_mass("k2", "Second mass to its contact DOF."),
        _two_mass("k_c1", "First contact DOF to the ground."),
        _two_mass("k_c2", "Second contact DOF to the ground."),
        _two_mass("k_p", "Coupling of the contact DOFs, off the diagonal."),
    )),
    Section("mistuning",
        "Blades that differ. All nodal diameters respond then, to one engine order. `[modes]` and "
        "`[model]` are left out. `slipmode run`, `plan`, `study` and `validate` take such a "
        "scene.", (
        Key("deviation", numbers(between(-0.9, 0.9)), "-", None,
            "Relative deviation of each blade's stiffness; of matrices, of each sector's. Exactly "
            "one of `deviation` and `standard_deviation`."),
        Key("standard_deviation", number(between(1e-6, 0.2)), "-", None,
            "Standard deviation of normally distributed deviations, see `rom.random_mistuning`."),
        Key("seed", integer(), "-", 0, "Equal seeds draw equal deviations."),
    )),
    Section("friction",
        "Rigid contacts, all of one law. A scene has either this or groups `[[contacts]]`.", (
        Key("law", choice(*RIGID_LAWS), "-", MISSING,
            "Smoothed Coulomb friction mu N tanh(v / alpha), or exact Coulomb friction."),
        Key("limit", one_or_each(NON_NEGATIVE), "N", MISSING, "Friction limit mu N.", "limit"),
        Key("alpha", number(POSITIVE), "m/s", None,
            'Velocity that smooths the law; required with `law = "tanh"`, refused with '
            '"coulomb".'),
    )),
    Section("contacts",
        "Elastic contacts, in groups of one law each. The meaning of a parameter ends with the "
        "laws that have it.", CONTACT_KEYS, is_array=True,
        hints={key.name: "windows of contact motion are [[contact]]" for key in _WINDOW}),
    Section("preload",
        "A static force that presses frictional contacts together, or opens them, before "
        "anything vibrates; it acts in addition to the preloads of their law.", (
        Key("dof", either(integer(), integers(), "integer, or list of integers"), "-", None,
            "Where the force acts. Exactly one of `dof` and `vector`."),
        Key("force", one_or_each(FINITE, "DOF"), "N", None, "The force; required with `dof`."),
        Key("vector", either(text(), numbers(), "list of numbers, or string"), "N", None,
            "Force on every DOF, or the .npy file with it."),
    )),
    Section("limits", "Friction limits and preloads over time. Not under tanh, nor with gaps.", (
        Key("scale", script(POSITIVE), "-", None, "Factor on all friction limits and preloads.",
            "load"),
    )),
    Section("modes",
        "Which modes are retained, counted from 0 by frequency, with the contacts stuck. A saved "
        "model (`model.file`) has its own.", (
        Key("A", integer(), "-", MISSING, "Number of the first mode."),
        Key("B", integer(), "-", None,
            "Number of the second mode, another one; absent: a model of one mode."),
        Key("nodal_diameters", integers(FINITE), "-", None,
            "Of sectors: nodal diameter of each mode, negative for a backward wave; modes are "
            "counted from 0 for each. Default: those that the engine orders excite."),
    )),
    Section("forcing",
        "The force on a mode, amplitude cos(theta + phase) with theta' = frequency. Exactly one "
        "of `dof`, `node` and `vector` says where it acts. The table of mode B is `[forcing.B]`.",
        tuple(Section(mode, "", (
            Key("dof", integer(), "-", None, "The DOF that the force acts on."),
            Key("node", integer(FINITE), "-", None,
                "The node that it acts on, if the matrices name nodes; with `direction`."),
            Key("direction", choice(*DIRECTIONS), "-", None, "Its direction there."),
            Key("vector", numbers(), "-", None, "Force on every DOF, per unit of `amplitude`."),
            Key("amplitude",
                script(Rule(">= 0 (use phase to reverse the force)", NON_NEGATIVE.holds)),
                "N", MISSING, "Force amplitude over time.", "load"),
            Key("frequency", script(POSITIVE), "rad/s", None,
                "Forcing frequency over time, in `[units]`; sweeps are continuous in phase. "
                "Either this or `engine_order` is required.", "load"),
            Key("engine_order", integer(POSITIVE), "-", None,
                "Forcing frequency in multiples of `rotor_speed`. Of sectors it says which nodal "
                "diameter is excited; `dof` is then a DOF of every sector."),
            Key("rotor_speed", script(POSITIVE), "rpm", None,
                "Rotor speed over time in revolutions a minute; goes with `engine_order`.",
                "load"),
            Key("phase", script(), "rad", 0.0, "Phase over time.", "load"),
        )) for mode in MODES)),
    Section("initial", "Modal amplitudes at the start.", tuple(
        Key(mode, numbers(length=2), "kg^1/2 m", None,
            f"[re, im] of a_{mode} at t = 0; absent: 0.")
        for mode in MODES
    )),
    Section("aerodynamics",
        "Aerodynamic influence coefficients, by which a mode may excite itself.", tuple(
        Key(mode, numbers(length=2), "rad^2/s^2", None,
            f"[re, im] of the coefficient of mode {mode}; im < 0 feeds energy in.")
        for mode in MODES
    )),
    Section("run", "How long, and in which communication steps.", (
        Key("duration", number(POSITIVE), "s", MISSING, "End of the scene, which begins at 0."),
        Key("step", number(POSITIVE), "s", MISSING,
            "Communication step: how often amplitudes are recorded, at least duration / 1e7. The "
            "solver has steps of its own."),
        Key("tolerance", number(POSITIVE), "-", SLOW_FLOW,
            "Relative tolerance of the slow flow's solver."),
    )),
    Section("model", "How the reduced model is made, or the file of a saved one.", (
        Key("file", text(), "-", None,
            "A model saved by `Model.save`, relative to the scene. It replaces `[structure]`, "
            "`[friction]`, `[[contacts]]`, `[modes]` and the other keys of this table."),
        Key("tolerance", number(POSITIVE), "-", 1e-3, "Relative tolerance of the friction table."),
        Key("formulation", choice("consistent", "paper"), "-", "consistent",
            "The source paper's, or with the terms that its expansion neglects at first order."),
        Key("amplitude", replace(numbers(POSITIVE), words="list of one number per mode"),
            "kg^1/2 m", None, "Range of the friction table; if absent, a dry run finds it."),
        Key("table", choice("whole", "none"), "-", "whole",
            "A friction table, or none: the scene is integrated at full order."),
        Key("transients", choice("auto", "slow", "hybrid"), "-", "auto",
            "Full order where the estimated transient error of slow time exceeds the tolerance, "
            "at least 1 %; nowhere; or where it exceeds 0.1 %."),
        Key("budget", number(POSITIVE), "s", None,
            "Longest time that the friction table may take; a refusal says what is possible in "
            "it."),
    )),
    Section("contact",
        "A window of time in which the motion of the contacts is reconstructed, and of the DOFs "
        "of `[output]`. Windows must not overlap.", _WINDOW, is_array=True,
        hints={key.name: "the laws of contacts are in [[contacts]]" for key in CONTACT_KEYS}),
    Section("elastic", "A window in which the DOFs of `[output]` alone are reconstructed.",
        _WINDOW, is_array=True,
        hints={key.name: "the laws of contacts are in [[contacts]]" for key in CONTACT_KEYS}),
    Section("output", "DOFs of the structure that are reconstructed inside the windows.", (
        Key("elastic", integers(), "-", [], "DOFs, from 0."),
        Key("nodes", node_dofs("[node, direction]", (2,)), "-", [],
            "DOFs by node, if the matrices name nodes."),
    )),
    Section("log", "Which recordings are written.", (
        Key("mcap", boolean(), "-", True, "Write an MCAP file."),
        Key("rerun", boolean(), "-", True, "Write an .rrd file with views for Rerun."),
    )),
    Section("units", "In which the frequencies of forces are given, and curves shown.", (
        Key("frequency", choice(*get_args(FrequencyUnit)), "-", "rad/s",
            "Of forcing frequencies here, and of curves, their pictures and studies."),
        Key("displacement", choice(*get_args(LengthUnit)), "-", "m",
            "Of DOFs in curves and their pictures."),
    )),
))
# fmt: on


def scene_reference() -> dict[str, Section]:
    """Return every table of a scene file by its header as in TOML; "" is the file itself."""
    found = {"": SCENE}
    for section in SCENE.sections:
        nested = section.sections  # the same for each mode: the first stands for all
        header = f"{section.name}.{nested[0].name}" if nested else section.name
        header = f"[[{header}]]" if section.is_array else f"[{header}]"
        parts = nested[0].parts if nested else section.parts
        found[header] = Section(section.name, section.meaning, parts)
    return found


def table_text(table: str) -> str:
    """Return the keys of a table, "run" or "forcing.A" for instance, for a terminal.

    Raises SlipmodeError with the names of the tables if there is no such table.
    """
    sections = {header.strip("[]"): section for header, section in scene_reference().items()}
    if table not in sections:
        raise SlipmodeError(f"keys: must be one of {', '.join(filter(None, sections))}")
    lines = [sections[table].meaning]
    for key in sections[table].keys:
        allowed = f" {key.kind.allowed}" if key.kind.allowed else ""
        lines.append(f"{key.name}: {key.kind.words}{allowed} [{key.unit}], {key.shown_default}")
        lines.append(textwrap.indent(textwrap.fill(key.meaning, 95), "    "))
    return "\n".join(lines)
