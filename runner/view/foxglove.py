"""A layout for Foxglove, written with an MCAP file: plots, events, hysteresis loops."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from slipmode.rom.slow.units import SI, Units
from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.channels import EVENTS, Channel
from slipmode.runner.view.labels import in_units
from slipmode.runner.view.plots import Axis, Portrait, find_plots, legend, portraits, titled

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
    shown = [in_units(channel, units) for channel in channels]
    scaled = _Scaled(
        [channel for channel, _ in shown],
        {channel.topic: factors.tolist() for channel, factors in shown},
    )
    slow, motion = scaled.plots(fast=False), scaled.plots(fast=True)
    loops = [scaled.loop(each) for each in portraits(scaled.channels) if each.kind == "loop"]
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


class _Scaled(NamedTuple):
    """Channels in the units that are shown, and factors of their recorded values."""

    channels: list[Channel]
    factors: dict[str, list[float]]

    def plots(self, *, fast: bool) -> list[_Panel]:
        """Return the panels of slow time, or of fast motion."""
        panels = []
        for plot, found in find_plots(self.channels, fast=fast):
            paths = [
                self._path(each.channel, column, name)
                for each in found
                for column, name in zip(each.columns, each.names, strict=True)
            ]
            name = f"{plot.topic[1:]}-{plot.name}"
            panels.append(_plot(name, titled(plot, found), paths, synced=not fast))
        return panels

    def loop(self, portrait: Portrait) -> _Panel:
        """Return the panel of a hysteresis loop."""
        x, force = self._axis(portrait.x), self._axis(portrait.y)
        name, config = _plot(portrait.title.replace(" ", "-"), portrait.title, [force])
        return name, config | {"xAxisVal": "custom", "xAxisPath": x | {"enabled": True}}

    def _axis(self, axis: Axis) -> dict[str, str]:
        (channel,) = (each for each in self.channels if each.topic == axis.topic)
        return self._path(channel, channel.names.index(axis.field), axis.label)

    def _path(self, channel: Channel, column: int, name: str) -> dict[str, str]:
        """Return a field in the units that are shown, with its name in the legend."""
        factor = self.factors[channel.topic][column]
        value = f"{channel.topic}.{channel.names[column]}"
        value += f".@mul({factor!r})" if factor != 1.0 else ""
        return {"value": value, "label": legend(channel, column, name)}


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
