"""`slipmode scenes`: the shipped scenes, and the keys of scene files."""

from __future__ import annotations

import json
import textwrap
from argparse import Namespace

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.commands import Argument, Command, print_next
from slipmode.runner.scene.keys import SCENE
from slipmode.runner.scene.scene import load_scene, shipped_scenes
from slipmode.runner.scene.toml_table import Section


def commands() -> dict[str, Command]:
    """Return the command."""
    keys = "print the keys of a table of scene files: --keys run"
    schema = "print the JSON Schema of scene files, for editors: --schema > scene.json"
    return {
        "scenes": Command(
            _scenes,
            'scenes && cp "$(slipmode scenes --path two-mode)" mine.toml',
            Argument("--path", metavar="NAME", help="print where a shipped scene's file is"),
            Argument("--keys", metavar="TABLE", help=keys),
            Argument("--schema", action="store_true", help=schema),
        )
    }


def _scenes(options: Namespace) -> int:
    shipped = shipped_scenes()
    if options.schema:
        draft = {"$schema": "http://json-schema.org/draft-04/schema#"}
        print(json.dumps(draft | SCENE.schema, indent=1))
    elif options.keys is not None:
        print(_table_text(options.keys))
    elif options.path is not None:
        if options.path not in shipped:
            raise SlipmodeError(f"{options.path}: no such scene; scenes: {', '.join(shipped)}")
        print(shipped[options.path])
    else:
        width = max(len(name) for name in shipped)
        for name in shipped:
            print(f"{name:{width}}  {load_scene(name).title}")
        print_next("slipmode", "run", next(iter(shipped)))
    return 0


def scene_reference() -> dict[str, Section]:
    """Return every table of a scene file by its header as in TOML; "" is the file itself."""
    found = {"": SCENE}
    for section in SCENE.sections:
        nested = section.sections  # the same for each mode: the first stands for all
        header = f"[{section.name}.{nested[0].name}]" if nested else section.header
        found[header] = nested[0] if nested else section
    return found


def _table_text(table: str) -> str:
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
