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
    unit_choice,
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
    return Key(name, kind, unit, default, f"{meaning} Laws: {laws}.", **role)


# fmt: off
# A table: each key in two lines, which formatted code would spread over eight.
CONTACT_KEYS = (
    Key("law", choice(*ELASTIC_LAWS), "-", MISSING, "Contact law of the group."),
    Key("contacts", integers(), "-", None,
        "Contact DOFs of the group, from 0. Default for a single group: all contact DOFs."),
    _law("limit", one_or_each(NON_NEGATIVE), "N",
         "Friction limit mu N; a list for `sliders`.", role="limit"),
    _law("stiffness", one_or_each(POSITIVE), "N/m",
         "Stiffness in stick; a list for `sliders`, one number for `iwan`."),
    _law("force", number(POSITIVE), "N", "Force of macro-slip.", role="limit"),
    _law("chi", number(), "-", "Exponent of the slider density, -1 < chi <= 1."),
    _law("beta", number(NON_NEGATIVE), "-",
         "Stiffness of the sliders that slip at macro-slip, relative to all other sliders."),
    _law("sliders", integer(), "-", "Number of sliders, 2 to 1000."),
    _law("mu", one_or_each(NON_NEGATIVE), "-", "Coefficient of friction."),
    _law("preload", one_or_each(NON_NEGATIVE), "N", "Normal force at rest.", role="limit"),
    _law("tangential_stiffness", one_or_each(POSITIVE), "N/m", "Tangential stiffness in stick."),
    _law("normal_stiffness", one_or_each(POSITIVE), "N/m", "Normal stiffness in contact."),
    _law("gap", one_or_each(NON_NEGATIVE), "m",
         "Normal displacement at which the contact touches; 0 for a contact with preload."),
    _law("tangents", integer(), "-",
         "Number of tangential directions of each contact, 1 or 2. The normal DOF is the last."),
)
_WINDOW = (
    Key("window", numbers(NON_NEGATIVE, 2), "s", MISSING,
        "[start, end], with start < end <= `run.duration`."),
    Key("samples_per_period", integer(between(8, 4096)), "-", 64,
        "Samples per period of the fastest carrier."),
)

SCENE = Section("", "At the top of the file, before any table.", (
    Key("title", text(), "-", "", "Title of recordings and pictures."),
    Section("structure",
        "The structure: the two-mass model, with the parameters from `contact_mass` on; matrices "
        "from files; or a bladed disk of equal sectors, whose modes are travelling waves.", (
        Key("model", choice("two-mass", "lumped-disk"), "-", None,
            "`rom.two_mass`, Table 1 of the source paper, or `rom.lumped_disk`. Give either "
            "`model` or `matrices`."),
        Key("matrices", text(), "-", None,
            "File or folder of matrices for `rom.load_structure`, relative to the scene. With "
            "`sectors`: matrices of one sector."),
        Key("damping", number(NON_NEGATIVE), "s", None,
            "Factor beta of C = beta K. Default: as in `rom.two_mass` or `rom.lumped_disk`; for "
            "matrices the damping in their files."),
        Key("sectors", integer(at_least(3)), "-", None,
            "Number of sectors of a bladed disk, required for matrices of one sector. Default for "
            "the lumped disk: 24."),
        Key("blade_stiffnesses", numbers(POSITIVE, 2), "N/m", None,
            "Stiffnesses of the lumped disk: between disk and first blade mass, and between the "
            "blade masses. Default: as in `rom.lumped_disk`."),
        Key("left", integers(), "-", None,
            "DOFs on the left side of the sector. Other keys of the scene number all DOFs except "
            "`right`, from 0."),
        Key("right", integers(), "-", None,
            "DOFs on the right side, in the order of the DOFs `left` of the next sector."),
        Key("interface", pairs_of_integers("[left node, right node]"), "-", None,
            "Instead of `left` and `right`: pairs of nodes. The right node coincides with the "
            "left node of the next sector."),
        Key("next_contacts", node_dofs("[contact, node, direction]", (3,)), "-", None,
            "Node of the next sector that each contact touches. The contact displacement is "
            "relative to this node."),
        Key("mass", text(), "-", None,
            "File of the mass matrix, if the file `matrices` has the stiffness alone."),
        Key("mass_name", text(), "-", None,
            "Name of the mass matrix in a file with several matrices. Default: see "
            "`rom.load_structure`."),
        Key("stiffness_name", text(), "-", None, "Name of the stiffness matrix, likewise."),
        Key("damping_name", text(), "-", None, "Name of the damping matrix, likewise."),
        Key("contacts", node_dofs("[node, direction] or [node, node, direction]", (2, 3)), "-",
            None,
            "Contact DOFs by node; two nodes give a relative displacement. Default: contacts in "
            "the file of `matrices`."),
        Key("rayleigh", numbers(NON_NEGATIVE, 2), "1/s, s", None,
            "[alpha, beta] of C = alpha M + beta K, instead of `damping`."),
        _two_mass("contact_mass", "Mass of each contact DOF, > 0.", "kg"),
        _two_mass("m1", "First modal mass, > 0.", "kg"),
        _two_mass("m2", "Second modal mass, > 0.", "kg"),
        _two_mass("k1", "Stiffness between the first modal mass and its contact DOF."),
        _two_mass("k2", "Stiffness between the second modal mass and its contact DOF."),
        _two_mass("k_c1", "Stiffness between the first contact DOF and the ground."),
        _two_mass("k_c2", "Stiffness between the second contact DOF and the ground."),
        _two_mass("k_p", "Off-diagonal stiffness between the contact DOFs."),
    )),
    Section("mistuning",
        "Deviations of the blades of a disk. All nodal diameters respond to one engine order. The "
        "tables `[modes]` and `[model]` are not allowed. Only `slipmode run`, `plan`, `study` and "
        "`validate` accept such a scene.", (
        Key("deviation", numbers(between(-0.9, 0.9)), "-", None,
            "Relative stiffness deviation of each blade; for matrices, of each sector. Give "
            "either `deviation` or `standard_deviation`."),
        Key("standard_deviation", number(between(1e-6, 0.2)), "-", None,
            "Standard deviation of normally distributed deviations, see `rom.random_mistuning`."),
        Key("seed", integer(), "-", 0, "Seed of the random deviations."),
    )),
    Section("friction",
        "Rigid contacts with one law. A scene has either `[friction]` or groups `[[contacts]]`.", (
        Key("law", choice(*RIGID_LAWS), "-", MISSING,
            "Regularised Coulomb friction mu N tanh(v / alpha), or exact Coulomb friction."),
        Key("limit", one_or_each(NON_NEGATIVE), "N", MISSING, "Friction limit mu N.", "limit"),
        Key("alpha", number(POSITIVE), "m/s", None,
            'Regularisation velocity; required with `law = "tanh"`, not allowed with "coulomb".'),
    )),
    Section("contacts",
        "Elastic contacts, in groups with one law each. The meaning of a parameter ends with the "
        "laws that have it.", CONTACT_KEYS, is_array=True,
        hints={key.name: "windows of contact motion are [[contact]]" for key in _WINDOW}),
    Section("preload",
        "A static force that presses frictional contacts together, or opens them, before the "
        "vibration starts. It acts in addition to the preloads of the contact law.", (
        Key("dof", either(integer(), integers(), "integer, or list of integers"), "-", None,
            "DOFs on which the force acts. Give either `dof` or `vector`."),
        Key("force", one_or_each(FINITE, "DOF"), "N", None, "Force at `dof`; required with it."),
        Key("vector", either(text(), numbers(), "list of numbers, or string"), "N", None,
            "Force on every DOF, or a .npy file with these forces."),
    )),
    Section("limits", "Friction limits and preloads over time. Not allowed with `tanh` or gaps.", (
        Key("scale", script(POSITIVE), "-", None, "Factor on all friction limits and preloads.",
            "load"),
    )),
    Section("modes",
        "Retained modes with stuck contacts, counted from 0 by frequency. Not allowed with a "
        "saved model (`model.file`), which has its own modes.", (
        Key("A", either(integer(), integers(), "integer, or list of integers"), "-", MISSING,
            "Number of the first mode, or of several modes within 15 % that `[forcing.A]` moves "
            "together: A, A2, A3, ... in recordings."),
        Key("B", either(integer(), integers(), "integer, or list of integers"), "-", None,
            "Number of the second mode, different from A, or of several modes that `[forcing.B]` "
            "moves together: B, B2, ... Default: a model with the modes A."),
        Key("ratio", number(POSITIVE), "-", None,
            "Frequency of mode B relative to that of mode A, for instance 3, if a harmonic of the "
            "contacts drives mode B (internal resonance). There is no `[forcing.B]` then. "
            "Default: mode B has a force and a frequency of its own."),
        Key("nodal_diameters", integers(FINITE), "-", None,
            "Nodal diameter of each mode of a bladed disk, negative for a backward wave. Modes "
            "are counted from 0 for each. Default: the diameters that the engine orders excite."),
    )),
    Section("forcing",
        "Force on mode A, amplitude cos(theta + phase) with theta' = frequency. Give one of "
        "`dof`, `node` and `vector`. The table for mode B is `[forcing.B]`.",
        tuple(Section(mode, "", (
            Key("dof", integer(), "-", None, "DOF on which the force acts."),
            Key("node", integer(FINITE), "-", None,
                "Node on which the force acts, if the matrices have node numbers."),
            Key("direction", choice(*DIRECTIONS), "-", None, "Direction of the force at `node`."),
            Key("vector", numbers(), "-", None, "Force on every DOF per unit of `amplitude`."),
            Key("quadrature", either(integer(), numbers(), "integer, or list of numbers"), "-",
                None, "DOF, or force on every DOF per unit of `amplitude`, a quarter of a period "
                "later, so that the force rotates. With several modes on a tone."),
            Key("amplitude",
                script(Rule(">= 0 (use phase to reverse the force)", NON_NEGATIVE.holds)),
                "N", MISSING, "Force amplitude over time.", "load"),
            Key("frequency", script(POSITIVE), "rad/s", None,
                "Forcing frequency over time, in the unit of `[units]`. Sweeps are continuous in "
                "phase. Give either `frequency` or `engine_order`.", "load"),
            Key("engine_order", integer(POSITIVE), "-", None,
                "Forcing frequency as a multiple of `rotor_speed`. For a bladed disk it "
                "determines the excited nodal diameter, and `dof` is a DOF of every sector."),
            Key("rotor_speed", script(POSITIVE), "rpm", None,
                "Rotor speed over time in revolutions per minute, with `engine_order`.",
                "load"),
            Key("phase", script(), "rad", 0.0, "Phase of the force over time.", "load"),
        )) for mode in MODES)),
    Section("initial", "Modal amplitudes at the start.", tuple(
        Key(mode, numbers(length=2), "kg^1/2 m", None,
            f"[re, im] of the amplitude a_{mode} at t = 0. Default: 0.")
        for mode in MODES
    )),
    Section("aerodynamics",
        "Aerodynamic influence coefficients, which may make a mode self-excited.", tuple(
        Key(mode, numbers(length=2), "rad^2/s^2", None,
            f"[re, im] of the coefficient c_{mode}; im < 0 supplies energy to the mode.")
        for mode in MODES
    )),
    Section("run", "Duration and communication steps.", (
        Key("duration", number(POSITIVE), "s", MISSING, "End of the scene; it starts at 0."),
        Key("step", number(POSITIVE), "s", MISSING,
            "Communication step, the interval of recorded amplitudes, at least duration / 1e7. "
            "The solver chooses its internal steps."),
        Key("tolerance", number(POSITIVE), "-", SLOW_FLOW,
            "Relative tolerance of the solver of the slow flow."),
    )),
    Section("model", "Options of the reduced model, or the file of a saved model.", (
        Key("file", text(), "-", None,
            "A model saved by `Model.save`, relative to the scene. It replaces `[structure]`, "
            "`[friction]`, `[[contacts]]`, `[modes]` and the other keys of this table."),
        Key("tolerance", number(POSITIVE), "-", 1e-3, "Relative tolerance of the friction table."),
        Key("formulation", choice("consistent", "paper"), "-", "consistent",
            'Formulation of the contact problem. "paper" is the formulation of the source paper; '
            '"consistent" adds the terms of first order that it neglects.'),
        Key("amplitude", replace(numbers(POSITIVE), words="list of one number per mode"),
            "kg^1/2 m", None, "Amplitude range of the friction table. Default: from a dry run."),
        Key("table", choice("whole", "none"), "-", "whole",
            '"whole": with a friction table. "none": time integration at full order.'),
        Key("transients", choice("auto", "slow", "hybrid"), "-", "auto",
            'Where to integrate at full order. "auto": where the estimated transient error '
            'exceeds the tolerance, at least 1 %. "slow": nowhere. "hybrid": where it exceeds '
            "0.1 %."),
        Key("budget", number(POSITIVE), "s", None,
            "Largest computing time of the friction table. If it is too short, the message states "
            "what is possible in this time. Default: a limit of the work, some minutes."),
    )),
    Section("contact",
        "A time window with the fast motion of the contacts and of the DOFs in `[output]`. "
        "Windows must not overlap.", _WINDOW, is_array=True,
        hints={key.name: "the laws of contacts are in [[contacts]]" for key in CONTACT_KEYS}),
    Section("elastic", "A time window with the fast motion of the DOFs in `[output]` alone.",
        _WINDOW, is_array=True,
        hints={key.name: "the laws of contacts are in [[contacts]]" for key in CONTACT_KEYS}),
    Section("output", "DOFs of the structure whose motion is recorded in the windows.", (
        Key("elastic", integers(), "-", [], "DOFs, from 0."),
        Key("nodes", node_dofs("[node, direction]", (2,)), "-", [],
            "DOFs by node, if the matrices have node numbers."),
    )),
    Section("log", "Recordings to write.", (
        Key("mcap", boolean(), "-", True, "Write an MCAP file."),
        Key("rerun", boolean(), "-", True, "Write an .rrd file with views for Rerun."),
    )),
    Section("units", "Units of forcing frequencies, and of curves and studies.", (
        Key("frequency", unit_choice(*get_args(FrequencyUnit)), "-", "rad/s",
            "Unit of forcing frequencies in this file, and of frequencies in curves and studies."),
        Key("displacement", unit_choice(*get_args(LengthUnit)), "-", "m",
            "Unit of displacements of DOFs in curves and plots."),
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
