"""A layout for Foxglove, written with an MCAP file: plots, events, hysteresis loops."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.channels import EVENTS, Channel
from slipmode.runner.recording.record import Header
from slipmode.runner.view.labels import shown_channels
from slipmode.runner.view.plots import Portrait, find_plots, legend, portraits, titled

_Panel = tuple[str, dict[str, Any]]


def write_layout(mcap: Path, header: Header, channels: Sequence[Channel]) -> None:
    """Write ``two-mode.foxglove.json`` next to ``two-mode.mcap``.

    Plots are in the units of `shown_channels`, the file is in SI units. Foxglove opens the layout
    by its menu of layouts, Import from file. Raises OSError if it cannot be written.
    """
    with replacing(mcap.with_suffix(".foxglove.json")) as file:
        file.write(json.dumps(layout(header, channels), indent=1).encode())


def layout(header: Header, channels: Sequence[Channel]) -> dict[str, Any]:
    """Return the layout: slow time to the left, fast motion, loops and events to the right."""
    shown = {each.channel.topic: each for each in shown_channels(channels, header)}
    listed = [each.channel for each in shown.values()]

    def path(topic: str, column: int, name: str) -> dict[str, str]:
        """Return a field in the units that are shown, with its name in the legend."""
        channel, source, columns, factors = shown[topic]
        value, factor = f"{source.topic}.{source.names[columns[column]]}", factors[column].item()
        value += f".@mul({factor!r})" if factor != 1.0 else ""
        return {"value": value, "label": legend(channel, column, name)}

    def plots(*, fast: bool) -> list[_Panel]:
        panels = []
        for plot, found in find_plots(listed, fast=fast):
            paths = [
                path(each.channel.topic, column, name)
                for each in found
                for column, name in zip(each.columns, each.names, strict=True)
            ]
            name = f"{plot.topic[1:]}-{plot.name}"
            panels.append(_plot(name, titled(plot, found), paths, synced=not fast))
        return panels

    def loop(portrait: Portrait) -> _Panel:
        x, force = (
            path(axis.topic, shown[axis.topic].channel.names.index(axis.field), axis.label)
            for axis in (portrait.x, portrait.y)
        )
        name, config = _plot(portrait.title.replace(" ", "-"), portrait.title, [force])
        return name, config | {"xAxisVal": "custom", "xAxisPath": x | {"enabled": True}}

    slow, motion = plots(fast=False), plots(fast=True)
    loops = [loop(each) for each in portraits(listed) if each.kind == "loop"]
    log: _Panel = ("RosOut!events", {"topicToRender": EVENTS, "foxglovePanelTitle": "Events"})
    columns = [column for column in (slow, motion, [*loops, log]) if column]
    stacks = [_split([*dict(column)], "column") for column in columns]
    return {
        "configById": dict([*slow, *motion, *loops, log]),
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split(stacks, "row"),
    }


def _plot(name: str, title: str, paths: list[dict[str, str]], *, synced: bool = False) -> _Panel:
    line = {"enabled": True, "timestampMethod": "receiveTime", "showLine": True}
    config = {
        "foxglovePanelTitle": title,
        "paths": [path | line for path in paths],
        "xAxisVal": "timestamp",
        "showLegend": True,
        "legendDisplay": "top",  # beside the curves, not over them
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "isSynced": synced,
    }
    return f"Plot!{name}", config


def _split(parts: list[Any], direction: str) -> Any:
    """Return parts of equal size side by side, or above one another."""
    first, *rest = parts
    if not rest:
        return first
    return {
        "direction": direction,
        "first": first,
        "second": _split(rest, direction),
        "splitPercentage": round(100.0 / len(parts), 2),
    }
