"""The keys of scene files in Markdown, from their declarations."""

from slipmode.runner.commands.scenes import scene_reference
from slipmode.runner.scene.toml_table import Section


def as_markdown() -> str:
    """The reference as sections of tables."""
    return "\n\n".join(_section(*each) for each in scene_reference().items())


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
