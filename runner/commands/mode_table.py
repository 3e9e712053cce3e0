"""The modes of a scene or of a file of matrices: `slipmode modes`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from slipmode import rom
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import RigidFriction
from slipmode.runner.scene.contacts import loaded_law
from slipmode.runner.scene.scene import load_scene, shipped_scenes


def is_scene(file: str) -> bool:
    """Return whether a word of the command line names a scene, not a file of matrices."""
    return file in shipped_scenes() or Path(file).suffix == ".toml"


def mode_table(
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
    if is_scene(file):
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
