"""Every key of a scene file in words: value, unit, default, what is allowed, meaning.

Which keys there are is the reader's own list, and a key without words here is an error;
defaults of parameters are those of the Python functions and laws that take them.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields

from slipmode.rom.error_budget import SLOW_FLOW
from slipmode.rom.structure.structure import two_mass
from slipmode.runner.scene.contacts import CONTACTS, ELASTIC
from slipmode.runner.scene.scene import FORCING, SECTIONS, WINDOW

_REQUIRED = "required"
_OPTIONAL = "-"


@dataclass(frozen=True)
class Key:
    """One key of a scene file.

    Attributes
    ----------
    name : str
        In its table.
    value : str
        "number", "integer", "string", "boolean", "script" (a number or breakpoints
        [[t, value], ...]), "list of ..." or alternatives of these.
    allowed : str
        As a refusal says it; empty if the kind of value says all.
    unit : str
        "-" where there is none.
    default : str
        As in TOML; "required", or "-" for a key that may be absent and has no default.
    meaning : str
    """

    name: str
    value: str
    allowed: str
    unit: str
    default: str
    meaning: str


@dataclass(frozen=True)
class Section:
    """A table of a scene file: its header as in TOML, what it is for, and its keys."""

    header: str
    meaning: str
    keys: tuple[Key, ...]


_Words = tuple[str, str, str, str, str]  # of a Key, all but its name

_MEANINGS = {
    "": "At the top of the file, before any table.",
    "structure": (
        "What vibrates: the model of two masses, with the parameters from `contact_mass` on, or "
        "matrices from files."
    ),
    "friction": (
        "Rigid contacts, all of one law. A scene has either this or groups `[[contacts]]`."
    ),
    "contacts": (
        "Elastic contacts, in groups of one law each. Which parameters a law has is said with "
        "each of them."
    ),
    "preload": (
        "A static force that presses frictional contacts together, or opens them, before "
        "anything vibrates; it acts besides the preloads of their law."
    ),
    "limits": "Friction limits and preloads over time. Not under tanh, nor with gaps.",
    "modes": "Which modes are retained, counted from 0 by frequency, with the contacts stuck.",
    "forcing": (
        "The force on a mode, amplitude cos(theta + phase) with theta' = frequency. Exactly one "
        "of `dof`, `node` and `vector` says where it acts. The table of mode B is `[forcing.B]`."
    ),
    "initial": "Modal amplitudes at the start.",
    "aerodynamics": "Aerodynamic influence coefficients, by which a mode may excite itself.",
    "run": "How long, and in which communication steps.",
    "model": "How the reduced model is made.",
    "contact": (
        "A window of time in which the motion of the contacts is reconstructed, and that of the "
        "DOFs of `[output]`. Windows must not overlap."
    ),
    "elastic": "A window in which the DOFs of `[output]` alone are reconstructed.",
    "output": "DOFs of the structure that are reconstructed inside the windows.",
    "units": "In which the frequencies of forces are given, and curves shown.",
    "log": "Which recordings are written.",
}

_SCRIPT = "number, or breakpoints [[t, value], ...]"
_ONE_OR_EACH = "number, or list of one per contact"

_WORDS: dict[str, dict[str, _Words]] = {
    "": {"title": ("string", "", "-", '""', "What recordings and pictures are called.")},
    "structure": {
        "model": (
            *("string", '"two-mass"', "-", _OPTIONAL),
            "The model of Table 1 of the source paper. Exactly one of `model` and `matrices`.",
        ),
        "matrices": (
            *("string", "", "-", _OPTIONAL),
            "File or folder of matrices that `rom.load_structure` reads, relative to the scene.",
        ),
        "damping": (
            *("number", ">= 0", "s", _OPTIONAL),
            "beta of damping proportional to stiffness, C = beta K. Default: 0.01 for the two "
            "masses, what the files have for matrices.",
        ),
        "mass": (
            *("string", "", "-", _OPTIONAL),
            "File of the mass, where `matrices` has the stiffness alone.",
        ),
        "contacts": (
            *("list of [node, direction] or [node, node, direction]", "", "-", _OPTIONAL),
            "Contact DOFs by node; of two nodes: their relative motion. Overrides the file's.",
        ),
        "rayleigh": (
            *("list of 2 numbers", ">= 0", "1/s, s", _OPTIONAL),
            "[alpha, beta] of C = alpha M + beta K, instead of `damping`.",
        ),
        "contact_mass": ("number", "finite", "kg", "", "Mass of each contact DOF, > 0."),
        "m1": ("number", "finite", "kg", "", "First modal mass, > 0."),
        "m2": ("number", "finite", "kg", "", "Second modal mass, > 0."),
        "k1": ("number", "finite", "N/m", "", "First mass to its contact DOF."),
        "k2": ("number", "finite", "N/m", "", "Second mass to its contact DOF."),
        "k_c1": ("number", "finite", "N/m", "", "First contact DOF to the ground."),
        "k_c2": ("number", "finite", "N/m", "", "Second contact DOF to the ground."),
        "k_p": ("number", "finite", "N/m", "", "Coupling of the contact DOFs, off the diagonal."),
    },
    "friction": {
        "law": (
            *("string", '"tanh", "coulomb"', "-", _REQUIRED),
            "Smoothed Coulomb friction mu N tanh(v / alpha), or exact Coulomb friction.",
        ),
        "limit": (
            *(_ONE_OR_EACH, ">= 0", "N", _REQUIRED),
            "Friction limit mu N.",
        ),
        "alpha": (
            *("number", "> 0", "m/s", _OPTIONAL),
            'Velocity that smooths; required with `law = "tanh"`, refused with "coulomb".',
        ),
    },
    "contacts": {
        "law": ("string", "", "-", _REQUIRED, "What the contacts of the group are."),
        "contacts": (
            *("list of integers", ">= 0", "-", _OPTIONAL),
            "Their contact DOFs, from 0; all of them if absent, which a single group may do.",
        ),
        "limit": (_ONE_OR_EACH, ">= 0", "N", "", "Friction limit mu N; of `sliders` a list."),
        "stiffness": (
            *(_ONE_OR_EACH, "> 0", "N/m", ""),
            "While the contact sticks; of `sliders` a list, of `iwan` one number.",
        ),
        "force": ("number", "> 0", "N", "", "Force of macro-slip."),
        "chi": ("number", "finite", "-", "", "Exponent of the sliders' density, -1 < chi <= 0."),
        "beta": (
            *("number", ">= 0", "-", ""),
            "Stiffness of the sliders that give way at macro-slip, relative to the others.",
        ),
        "sliders": ("integer", ">= 0", "-", "", "Number of sliders, 2 to 1000."),
        "mu": (_ONE_OR_EACH, ">= 0", "-", "", "Coefficient of friction."),
        "preload": (_ONE_OR_EACH, ">= 0", "N", "", "Normal force at rest."),
        "tangential_stiffness": (_ONE_OR_EACH, "> 0", "N/m", "", "While the contact sticks."),
        "normal_stiffness": (_ONE_OR_EACH, "> 0", "N/m", "", "While the contact touches."),
        "gap": (
            *(_ONE_OR_EACH, ">= 0", "m", ""),
            "Normal displacement at which the contact touches; 0 where there is a preload.",
        ),
        "tangents": (
            *("integer", ">= 0", "-", ""),
            "Tangential directions of each contact, 1 or 2; its normal DOF comes after them.",
        ),
    },
    "preload": {
        "dof": (
            *("integer, or list of integers", ">= 0", "-", _OPTIONAL),
            "Where it acts. Exactly one of `dof` and `vector`.",
        ),
        "force": (
            *("number, or list of one per DOF", "finite", "N", _OPTIONAL),
            "The force; required with `dof`.",
        ),
        "vector": (
            *("list of numbers, or string", "", "N", _OPTIONAL),
            "The force on every DOF, or the .npy file that has it.",
        ),
    },
    "limits": {
        "scale": (_SCRIPT, "> 0", "-", _OPTIONAL, "Factor on all friction limits and preloads."),
    },
    "modes": {
        "A": ("integer", ">= 0", "-", _REQUIRED, "Number of the first mode."),
        "B": (
            *("integer", ">= 0", "-", _OPTIONAL),
            "Number of the second mode, another one; absent: a model of one mode.",
        ),
    },
    "forcing": {
        "dof": ("integer", ">= 0", "-", _OPTIONAL, "The DOF that the force acts on."),
        "node": (
            *("integer", "finite", "-", _OPTIONAL),
            "The node that it acts on, where the matrices name nodes; with `direction`.",
        ),
        "direction": (
            *("string", '"x", "y", "z", "rx", "ry", "rz"', "-", _OPTIONAL),
            "Its direction there.",
        ),
        "vector": (
            *("list of numbers", "finite", "-", _OPTIONAL),
            "Force on every DOF, per unit of `amplitude`.",
        ),
        "amplitude": (_SCRIPT, ">= 0", "N", _REQUIRED, "Force amplitude over time."),
        "frequency": (
            *(_SCRIPT, "> 0", "rad/s", _REQUIRED),
            "Forcing frequency over time, in `[units]`; sweeps are continuous in phase.",
        ),
        "phase": (_SCRIPT, "finite", "rad", "0.0", "Phase over time."),
    },
    "initial": {
        "A": (
            *("list of 2 numbers", "finite", "kg^1/2 m", _OPTIONAL),
            "[re, im] of a_A at t = 0; absent: at rest.",
        ),
        "B": ("list of 2 numbers", "finite", "kg^1/2 m", _OPTIONAL, "The same of a_B."),
    },
    "aerodynamics": {
        "A": (
            *("list of 2 numbers", "finite", "rad^2/s^2", _OPTIONAL),
            "[re, im] of the coefficient of mode A; im < 0 feeds energy in.",
        ),
        "B": ("list of 2 numbers", "finite", "rad^2/s^2", _OPTIONAL, "The same of mode B."),
    },
    "run": {
        "duration": ("number", "> 0", "s", _REQUIRED, "End of the scene, which begins at 0."),
        "step": (
            *("number", "> 0", "s", _REQUIRED),
            "Communication step: how often amplitudes are recorded, at least duration / 1e7. The "
            "solver has steps of its own.",
        ),
        "tolerance": (
            *("number", "> 0", "-", f"{SLOW_FLOW:g}"),
            "Relative tolerance of the slow flow's solver.",
        ),
    },
    "model": {
        "tolerance": ("number", "> 0", "-", "0.001", "Relative tolerance of the friction table."),
        "formulation": (
            *("string", '"consistent", "paper"', "-", '"consistent"'),
            "The source paper's, or with what its expansion leaves out at first order.",
        ),
        "amplitude": (
            *("list of one number per mode", "> 0", "kg^1/2 m", _OPTIONAL),
            "Range of the friction table; absent: as far as a dry run says.",
        ),
        "table": (
            *("string", '"whole", "none"', "-", '"whole"'),
            "A friction table, or none: the scene is integrated at full order.",
        ),
        "transients": (
            *("string", '"auto", "slow", "hybrid"', "-", '"auto"'),
            "Full order where the estimated transient error of slow time exceeds the tolerance, "
            "at least 1 %; nowhere; or where it exceeds 0.1 %.",
        ),
        "budget": (
            *("number", "> 0", "s", _OPTIONAL),
            "Longest that the friction table may take; a refusal says what can be made by then.",
        ),
    },
    "output": {
        "elastic": ("list of integers", ">= 0", "-", _OPTIONAL, "DOFs, from 0."),
        "nodes": (
            *("list of [node, direction]", "", "-", _OPTIONAL),
            "DOFs by node, where the matrices name nodes.",
        ),
    },
    "log": {
        "mcap": ("boolean", "", "-", "true", "Write an MCAP file."),
        "rerun": ("boolean", "", "-", "true", "Write an .rrd file with views for Rerun."),
    },
    "units": {
        "frequency": (
            *("string", '"rad/s", "Hz"', "-", '"rad/s"'),
            "Of forcing frequencies here, and of those in curves, their pictures and studies.",
        ),
        "displacement": (
            *("string", '"m", "mm", "um"', "-", '"m"'),
            "Of DOFs in curves and their pictures.",
        ),
    },
}
_WINDOWS: dict[str, _Words] = {
    "window": (
        *("list of 2 numbers", ">= 0", "s", _REQUIRED),
        "[start, end], up to the scene's duration; start before end.",
    ),
    "samples_per_period": (
        *("integer", "8 to 4096", "-", "64"),
        "Samples in a period of the fastest carrier.",
    ),
}
_HEADERS = {"": "", "contacts": "[[contacts]]", "contact": "[[contact]]", "elastic": "[[elastic]]"}


def scene_reference() -> tuple[Section, ...]:
    """Every section of a scene file with every key that the reader takes.

    Raises
    ------
    KeyError
        If the reader takes a key that has no words here.
    """
    return tuple(
        Section(
            _HEADERS.get(name, "[forcing.A]" if name == "forcing" else f"[{name}]"),
            _MEANINGS[name],
            tuple(_key(name, key) for key in keys),
        )
        for name, keys in _sections()
    )


def _sections() -> Iterator[tuple[str, tuple[str, ...]]]:
    """The reader's tables and their keys, in the order in which a scene is written."""
    yield "", ("title",)
    for name, keys in SECTIONS.items():
        yield name, FORCING if name == "forcing" else keys
        if name == "friction":
            yield "contacts", CONTACTS
        if name == "model":
            yield "contact", WINDOW
            yield "elastic", WINDOW


def _key(section: str, name: str) -> Key:
    words = _WINDOWS if section in ("contact", "elastic") else _WORDS[section]
    value, allowed, unit, default, meaning = words[name]
    if section == "contacts":
        allowed = allowed or ", ".join(f'"{law}"' for law in ELASTIC)
        default, meaning = _of_laws(name, default, meaning)
    if section == "structure":
        default = default or f"{inspect.signature(two_mass).parameters[name].default:g}"
    return Key(name, value, allowed, unit, default, meaning)


def _of_laws(name: str, default: str, meaning: str) -> tuple[str, str]:
    """The default of a parameter of elastic laws, and its meaning with the laws that have it."""
    own = {law: f for law, kind in ELASTIC.items() for f in fields(kind) if f.name == name}
    if not own:
        return default, meaning
    defaults = {f.default for f in own.values()}
    (value,) = defaults
    laws = ", ".join(f"`{law}`" for law in own)
    return _REQUIRED if value is MISSING else f"{value:g}", f"{meaning} Of {laws}."


def as_markdown() -> str:
    """The reference as sections of tables."""
    return "\n\n".join(_section(section) for section in scene_reference())


def _section(section: Section) -> str:
    head = f"`{section.header}`" if section.header else "Top of the file"
    rows = [
        f"| `{key.name}` | {_value(key)} | {key.unit} | {_default(key.default)} | {key.meaning} |"
        for key in section.keys
    ]
    table = "\n".join(
        ("| key | value | unit | default | meaning |", "|---|---|---|---|---|", *rows)
    )
    return f"## {head}\n\n{section.meaning}\n\n{{.keys}}\n{table}"


def _value(key: Key) -> str:
    kinds = ", ".join(f"`{part}`" for part in key.allowed.split(", ")) if key.allowed else ""
    return f"{key.value}: {kinds}" if kinds else key.value


def _default(default: str) -> str:
    return default if default in (_REQUIRED, _OPTIONAL) else f"`{default}`"
