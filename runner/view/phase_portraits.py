"""One recorded quantity over another: phase portraits, trajectories, hysteresis loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import Channel
from slipmode.runner.view.charts import Axis, Box, box_view, span
from slipmode.runner.view.drawing import Path, draw_lines, draw_moving_point
from slipmode.runner.view.plots import GREY, Portrait, portraits
from slipmode.runner.view.samples import Extents, Latest, Thinned, Window, window_starts
from slipmode.runner.view.spatial.drawings import drawings

_ROW = 0.26  # height of a line of text in a portrait, relative to its box


def view_of(portrait: Portrait) -> rrb.View:
    """Return the view of a portrait."""
    return box_view(portrait.entity, portrait.title, _aspect(portrait), _ROW)


def _aspect(portrait: Portrait) -> float:
    return 1.0 if portrait.kind in ("plane", "orbit") else 1.6


def _has_picture(portrait: Portrait, path: Floats) -> bool:
    """Return whether values (n, 2) make a picture; a constant frequency makes none."""
    moves = len(path) > 0 and np.ptp(path[:, 0]) > 1e-6 * path[:, 0].max()
    return bool(moves) if portrait.kind == "response" else len(path) > 0


def _box(portrait: Portrait, path: Floats, units: Sequence[str]) -> Box:
    """Return the box around values (n, 2) in units."""
    names = portrait.x.label, portrait.y.label
    x, y = (Axis(f"{name} [{unit}]") for name, unit in zip(names, units, strict=True))
    if portrait.kind == "response":
        xs, ys = span(x, [path[:, 0]], False), span(y, [path[:, 1]], True)
    else:
        most = np.abs(path).max(axis=0)
        largest = np.full(2, most.max()) if _aspect(portrait) == 1.0 else most
        xs, ys = ((-1.05 * end, 1.05 * end) for end in np.where(largest, largest, 1.0).tolist())
    return Box(x, y, xs, ys, _aspect(portrait), _ROW)


@dataclass(frozen=True)
class FinalViews:
    """The entities of portraits with samples, the windows of fast motion, and all extents."""

    entities: tuple[str, ...]
    windows: tuple[Window, ...]
    extents: Extents


class Paths:
    """Keeps the samples that portraits show until their scales are known.

    Memory is bounded: of slow channels every second sample is dropped once they are many, of fast
    motion, which would lose its shape, all but the latest.
    """

    def __init__(self, channels: Sequence[Channel]) -> None:
        self._portraits, self._extents = portraits(channels), Extents()
        self._channels = {channel.topic: channel for channel in channels}
        self._samples: dict[str, Thinned | Latest] = {
            axis.topic: Latest() if portrait.fast else Thinned()
            for portrait in self._portraits
            for axis in (portrait.x, portrait.y)
        }
        if "/elastic" in self._channels:
            self._samples["/elastic"] = Latest()
        self._drawings = drawings(channels)
        for drawing in self._drawings:
            self._samples |= {topic: drawing.kept() for topic in drawing.topics}

    def extend(self, topic: str, time_ns: NDArray[np.int64], values: Floats) -> None:
        """Keep samples of a channel if some view needs them."""
        self._extents.extend(topic, time_ns, values)
        if topic in self._samples:
            self._samples[topic].extend(np.column_stack([time_ns, values]))

    def draw(self, stream: rr.RecordingStream) -> FinalViews:
        """Draw every portrait that has samples."""
        entities, motion = [], ""
        for portrait in self._portraits:
            time_ns, path = self._path(portrait)
            if not _has_picture(portrait, path):
                continue
            entities.append(portrait.entity)
            axes = portrait.x, portrait.y
            units = [self._channels[axis.topic].units[axis.field] for axis in axes]
            box = _box(portrait, path, units)
            box.draw(stream, portrait.entity)
            _draw_path(stream, portrait, time_ns, box.place(*path.T))
            if portrait.fast:
                motion = portrait.x.topic
        for drawing in self._drawings:
            rows = [self._samples[topic].rows() for topic in drawing.topics]
            if all(map(len, rows)):
                drawing.draw(stream, [self._channels[topic] for topic in drawing.topics], rows)
        shown = self._samples.get(motion or "/elastic")
        windows = shown.windows() if isinstance(shown, Latest) else []
        return FinalViews(tuple(entities), tuple(windows), self._extents)

    def _path(self, portrait: Portrait) -> tuple[NDArray[np.int64], Floats]:
        """Return times and points (n, 2) of the samples that both axes have."""
        samples = [self._samples[axis.topic].rows() for axis in (portrait.x, portrait.y)]
        count = min(len(kept) for kept in samples)
        if count == 0:
            return np.empty(0, np.int64), np.empty((0, 2))
        columns = [
            kept[:count, 1 + self._channels[axis.topic].names.index(axis.field)]
            for axis, kept in zip((portrait.x, portrait.y), samples, strict=True)
        ]
        return samples[0][:count, 0].astype(np.int64), np.column_stack(columns)


def _draw_path(
    stream: rr.RecordingStream, portrait: Portrait, time_ns: NDArray[np.int64], points: Floats
) -> None:
    """Draw the whole path thinly, its recent part brightly, and a moving point at its end."""
    starts = window_starts(time_ns)
    whole = np.split(points, np.unique(starts)[1:])
    color = portrait.color
    shade, radius = (GREY, 0.6) if portrait.fast else (color, 1.5)
    draw_lines(stream, f"{portrait.entity}/path", whole, shade, radius)
    path = Path(time_ns, points, starts, portrait.fast)
    draw_moving_point(stream, portrait.entity, path, color, GREY)
