"""The reference of scene files: the declarations of keys.py as Markdown and for a terminal."""

from __future__ import annotations

import textwrap

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.scene.keys import SCENE
from slipmode.runner.scene.toml_table import Section


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


def as_markdown() -> str:
    """Return the reference as sections of tables."""
    return "\n\n".join(_section(*each) for each in scene_reference().items())


def as_text(table: str) -> str:
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


def _section(header: str, section: Section) -> str:
    head = f"`{header}`" if header else "Top of the file"
    lines = ["| key | value | unit | default | meaning |", "|---|---|---|---|---|"]
    for key in section.keys:
        allowed = ", ".join(f"`{part}`" for part in key.kind.allowed.split(", ") if part)
        value = f"{key.kind.words}: {allowed}" if allowed else key.kind.words
        default = key.shown_default
        default = default if default in ("required", "-") else f"`{default}`"
        lines.append(f"| `{key.name}` | {value} | {key.unit} | {default} | {key.meaning} |")
    return f"## {head}\n\n{section.meaning}\n\n{{.keys}}\n" + "\n".join(lines)
