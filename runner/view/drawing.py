"""What drawings in Rerun share: labels, and a point that moves along a path with its tail."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen
from slipmode.runner.recording.channels import Channel
from slipmode.runner.view.plots import GREY, Color
from slipmode.runner.view.samples import Latest, Thinned

TIMELINE = "time"


@frozen
class Path:
    """Places of a moving point, (n, 2 or 3), at times (n,) [ns]."""

    time_ns: NDArray[np.int64]
    points: Floats
    starts: NDArray[np.int64]  # (n,): The first sample to which each is connected
    tail: bool  # Whether the point draws a tail


@dataclass(frozen=True, eq=False)
class Drawing:
    """A drawing in space."""

    title: str
    topics: tuple[str, ...]  # Of the channels that it shows
    kept: type[Latest | Thinned]  # Which of their samples
    view: Callable[[], rrb.View]
    # Draws samples of the channels: rows of time [ns] and values, at least one of each
    draw: Callable[[rr.RecordingStream, Sequence[Channel], Sequence[Floats]], None]
    slow: bool = False  # Whether it stands for the plots of its channels in slow time


def time_column(time_ns: NDArray[np.int64]) -> rr.TimeColumn:
    """Return simulation times [ns] on the recording's timeline."""
    return rr.TimeColumn(TIMELINE, duration=time_ns.astype("timedelta64[ns]"))


def draw_moving_point(
    stream: rr.RecordingStream, entity: str, path: Path, tail: Color, mark: Color
) -> None:
    """Draw up to 1000 places of a moving point, and its tail at each of them."""
    flat = path.points.shape[1] == 2
    strips, points = (rr.LineStrips2D, rr.Points2D) if flat else (rr.LineStrips3D, rr.Points3D)
    count = len(path.points)
    shown = np.linspace(0, count - 1, min(count, 1000)).astype(np.int64)
    index = [time_column(path.time_ns[shown])]
    if path.tail:
        above: dict[str, Any] = {"draw_order": 21.0} if flat else {}  # other lines have 20
        line = strips.from_fields(colors=tail, radii=rr.Radius.ui_points(1.5), **above)
        stream.log(f"{entity}/tail", line, static=True)
        # up to 96 samples: a period and a half of contact motion, at the usual sampling
        first = np.maximum(path.starts, np.arange(count) - 95)
        ends = [path.points[first[last] : last + 1] for last in shown]
        stream.send_columns(f"{entity}/tail", index, strips.columns(strips=ends))
    dot = points.from_fields(colors=mark, radii=rr.Radius.ui_points(5.0))
    stream.log(f"{entity}/now", dot, static=True)
    stream.send_columns(f"{entity}/now", index, points.columns(positions=path.points[shown]))


def draw_labels(
    stream: rr.RecordingStream,
    entity: str,
    labels: Mapping[Any, str],
    colors: Color | list[Color] = GREY,
    radius: float = 0.5,
) -> None:
    """Write texts at places (2 or 3 coordinates), each next to a dot."""
    kind: Any = rr.Points2D if len(next(iter(labels))) == 2 else rr.Points3D
    texts, radii = list(labels.values()), rr.Radius.ui_points(radius)
    points = kind(list(labels), labels=texts, show_labels=True, colors=colors, radii=radii)
    stream.log(f"{entity}/labels", points, static=True)


def draw_lines(
    stream: rr.RecordingStream, entity: str, lines: Any, color: Color, radius: float
) -> None:
    """Draw lines, each of points (n, 2 or 3), that do not change."""
    kind: Any = rr.LineStrips2D if len(lines[0][0]) == 2 else rr.LineStrips3D
    stream.log(entity, kind(lines, colors=color, radii=rr.Radius.ui_points(radius)), static=True)
