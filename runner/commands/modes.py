"""`slipmode modes`: the modes of a scene, or of a file of matrices."""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slipmode import rom
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import RigidFriction
from slipmode.runner.commands import Argument, Command, print_next
from slipmode.runner.scene.contacts import loaded_law
from slipmode.runner.scene.scene import load_scene, shipped_scenes


def commands() -> dict[str, Command]:
    """Return the command."""
    contact = "DOFs, or NODE:DIRECTION, or NODE-NODE:DIRECTION of two that touch"
    mass_name = "its name in a file with several matrices"
    return {
        "modes": Command(
            _modes,
            "modes job_STIF2.mtx --contact 4711:z 12-13:x --stiffness 1e7",
            Argument("file", help="a scene, or a file of matrices (see rom.load_structure)"),
            Argument("--mass", type=Path, help="file of the mass matrix, if it is separate"),
            Argument("--mass-name", metavar="NAME", help=mass_name),
            Argument("--stiffness-name", metavar="NAME", help="name of the stiffness matrix"),
            Argument("--damping-name", metavar="NAME", help="name of the damping matrix"),
            Argument("--contact", nargs="+", metavar="WHERE", help=contact),
            Argument("--stiffness", type=float, help="of elastic contacts [N/m] (bonded)"),
            Argument("-n", "--number", type=int, default=10, help="number of modes (10)"),
        )
    }


def _modes(options: Namespace) -> int:
    chosen = options.mass, options.contact, options.stiffness, options.number
    parts = ("mass", "stiffness", "damping")
    names = {part: name for part in parts if (name := getattr(options, f"{part}_name"))}
    print(_mode_table(options.file, *chosen, names=names))
    if _is_scene(options.file):
        print_next("slipmode", "curve", options.file)
    else:
        print_next("slipmode", "scenes", "--keys", "structure")
    return 0


def _is_scene(file: str) -> bool:
    """Return whether a word of the command line names a scene, not a file of matrices."""
    return file in shipped_scenes() or Path(file).suffix == ".toml"


def _mode_table(
    file: str,
    mass: Path | None = None,
    contact: Sequence[str] | None = None,
    stiffness: float | None = None,
    number: int = 10,
    names: Mapping[str, str] | None = None,
) -> rom.ModeTable:
    """Return the modes of a scene (file or shipped name), or of matrices with some contacts.

    Contacts are DOF indices, or NODE:DIRECTION, or NODE-NODE:DIRECTION; without a stiffness [N/m]
    they are rigid. `names` name the matrices in a file with several.
    """
    if _is_scene(file):
        if mass or contact or stiffness or names:
            raise SlipmodeError(
                "--mass, --contact, --stiffness, --..-name: are in the scene; leave them out"
            )
        scene = load_scene(file)
        structure = scene.build()
        law, _ = loaded_law(scene, structure)  # open contacts are not stuck
        elastic = None if isinstance(law, RigidFriction) else law
        return rom.modes(structure, elastic, number, progress=True)
    where = None if contact is None else _contacts(contact)
    structure = rom.load_structure(file, mass=mass, contact=where, names=names)
    springs = None if stiffness is None else rom.Jenkins(1.0, stiffness)
    return rom.modes(structure, springs, number, progress=True)


def _contacts(words: Sequence[str]) -> Any:
    if all(word.isdecimal() for word in words):
        return [int(word) for word in words]
    found = [re.fullmatch(r"(\d+)(?:-(\d+))?:(\w+)", word) for word in words]
    if not all(found):
        allowed = "DOFs, NODE:DIRECTION or NODE-NODE:DIRECTION"
        raise SlipmodeError(f"--contact: must be {allowed}, got {words[found.index(None)]!r}")
    named = [match.groups() for match in found if match]
    return [
        (int(a), direction) if b is None else (int(a), int(b), direction)
        for a, b, direction in named
    ]
