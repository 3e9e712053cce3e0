"""A layout for Foxglove, written with an MCAP file: plots, events, hysteresis loops."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from slipmode.rom.slow.units import SI, Units
from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.channels import EVENTS, Channel
from slipmode.runner.view.labels import (
    LOOPS,
    MOTION_PLOTS,
    SLOW_PLOTS,
    Series,
    find_plots,
    in_units,
    legend,
    titled,
)

_Panel = tuple[str, dict[str, Any]]


def write_layout(mcap: Path, channels: Sequence[Channel], units: Units = SI) -> None:
    """Write ``two-mode.foxglove.json`` next to ``two-mode.mcap``.

    Plots are in `units`, the file is in SI units. Foxglove opens the layout by its menu of
    layouts, Import from file. Raises OSError if it cannot be written.
    """
    with replacing(mcap.with_suffix(".foxglove.json")) as file:
        file.write(json.dumps(layout(channels, units), indent=1).encode())


def layout(channels: Sequence[Channel], units: Units = SI) -> dict[str, Any]:
    """Return the layout: slow time to the left, fast motion, loops and events to the right."""
    slow = _plots(channels, SLOW_PLOTS, units)
    motion = _plots(channels, MOTION_PLOTS, units)
    contacts = [channel for channel in channels if channel.topic.startswith("/contact/")]
    loops = [_loop(channel, units) for channel in contacts[:LOOPS]]
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


def _plots(
    channels: Sequence[Channel], wanted: Sequence[tuple[str, str, str]], units: Units
) -> list[_Panel]:
    panels = []
    for title, found in find_plots(channels, wanted).items():
        paths = [_path(channel, k, units) for channel, plot in found for k in plot.columns]
        panels.append(_plot(_titled(title, found, units), paths))
    return panels


def _titled(title: str, found: Sequence[tuple[Channel, Series]], units: Units) -> str:
    """Return the title of a plot with the unit that is shown."""
    return titled(title, [(in_units(channel, units)[0], plot) for channel, plot in found])


def _path(channel: Channel, column: int, units: Units) -> dict[str, str]:
    """Return a field in the units that are shown, with its name in the legend."""
    shown, factors = in_units(channel, units)
    factor = factors[column].item()
    value = f"{channel.topic}.{channel.names[column]}"
    value += f".@mul({factor!r})" if factor != 1.0 else ""
    return {"value": value, "label": legend(shown, column)}


def _loop(channel: Channel, units: Units) -> _Panel:
    x, force = (_path(channel, channel.names.index(name), units) for name in ("x", "f"))
    name, config = _plot(f"Hysteresis of contact {channel.topic.rpartition('/')[2]}", [force])
    return name, config | {"xAxisVal": "custom", "xAxisPath": x | {"enabled": True}}


def _plot(title: str, paths: list[dict[str, str]]) -> _Panel:
    name = title.partition(" [")[0]  # without the unit
    line = {"enabled": True, "timestampMethod": "receiveTime", "showLine": True}
    config = {
        "foxglovePanelTitle": title,
        "paths": [path | line for path in paths],
        "xAxisVal": "timestamp",
        "showLegend": True,
        "legendDisplay": "top",  # beside the curves, not over them
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "isSynced": name in {each for *_, each in SLOW_PLOTS},
    }
    return f"Plot!{name.replace(' ', '-').replace('|', '')}", config


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
