"""Charts of one quantity against another, without time, in Rerun: of studies and curves.

Rerun plots against time alone: a chart draws its own scales in a 2D view.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.runner.recording.record import create_file
from slipmode.runner.view.drawing import draw_labels, draw_lines
from slipmode.runner.view.plots import BLUE, DARK, GREY, Color
from slipmode.runner.view.viewer import FLUSH_SECONDS, application

_ASPECT = 1.6  # width of a box, heights are 1: views are wider than high


@frozen
class Layer:
    """Points (n,) of a chart, or curves through them."""

    x: Floats
    y: Floats  # NaN breaks a curve
    color: Color = BLUE
    name: str = ""  # In the key
    curve: bool = True
    width: float = 1.5  # Of the curve or the points, in points of the screen
    top: Floats | None = None  # Upper edge of a band, whose lower edge is y


@dataclass(frozen=True)
class Axis:
    """A scale: what it is of, with its unit; names of the values 0, 1, ... if they are none."""

    label: str
    names: tuple[str, ...] = ()
    log: bool = False


@dataclass(frozen=True)
class Chart:
    """Layers over the same two scales."""

    entity: str  # Its path in Rerun, "/steady/A"
    title: str
    x: Axis
    y: Axis
    layers: Sequence[Layer]
    from_zero: bool = True  # Whether y begins at 0

    def view(self) -> rrb.View:
        """Return the view of the chart: its box and its labels."""
        bounds = rrb.VisualBounds2D(x_range=(-0.3, _ASPECT + 0.1), y_range=(-1.12, 0.24))
        return rrb.Spatial2DView(origin=self.entity, name=self.title, visual_bounds=bounds)

    def draw(self, stream: rr.RecordingStream) -> None:
        """Draw the layers, the box with its scales, and the key."""
        xs = _span(self.x, [layer.x[np.isfinite(layer.y)] for layer in self.layers], False)
        heights = [layer.y for layer in self.layers]
        heights += [layer.top for layer in self.layers if layer.top is not None]
        ys = _span(self.y, heights, self.from_zero)
        self._box(stream, xs, ys)
        for k, layer in enumerate(self.layers):
            x = _ASPECT * _part(layer.x, xs, self.x.log)
            edges = [layer.y] if layer.top is None else [layer.y, layer.top]
            curves = [np.column_stack([x, -_part(edge, ys, self.y.log)]) for edge in edges]
            color, radius = layer.color, rr.Radius.ui_points(layer.width)
            marks: rr.LineStrips2D | rr.Points2D
            if layer.curve:
                strips = [strip for points in curves for strip in _strips(points)]
                marks = rr.LineStrips2D(strips, colors=color, radii=radius)
            else:
                seen = curves[0][np.isfinite(curves[0]).all(axis=1)]
                marks = rr.Points2D(seen, colors=color, radii=radius)
            stream.log(f"{self.entity}/layers/{k}", marks, static=True)

    def _box(
        self, stream: rr.RecordingStream, xs: tuple[float, float], ys: tuple[float, float]
    ) -> None:
        lines = [[(_ASPECT, 0.0), (0.0, 0.0), (0.0, -1.0)]]
        labels: dict[tuple[float, ...], str] = {}
        for value, text in _ticks(self.x, xs):
            at = _ASPECT * float(_part(np.array(value), xs, self.x.log))
            lines.append([(at, 0.0), (at, 0.02)])
            labels[at, 0.08] = text
        for value, text in _ticks(self.y, ys):
            at = -float(_part(np.array(value), ys, self.y.log))
            lines.append([(-0.015, at), (0.0, at)])
            labels[-0.13, at] = text
        labels[0.5 * _ASPECT, 0.19] = self.x.label
        labels[0.3, -1.08] = self.y.label
        colors = [GREY] * len(labels)
        for k, layer in enumerate(layer for layer in self.layers if layer.name):
            labels[_ASPECT - 0.25, -1.0 + k * 0.09] = layer.name
            colors.append(layer.color)
        draw_lines(stream, f"{self.entity}/box", lines, DARK, 0.5)
        draw_labels(stream, self.entity, labels, colors)


def write_charts(
    path: Path, title: str, rows: Sequence[Sequence[Chart]], texts: Mapping[str, str]
) -> None:
    """Write an .rrd file: rows of charts, and beneath them tabs of texts (Markdown) by name.

    Raises SlipmodeError if the file cannot be written.
    """
    try:
        create_file(path).close()  # Rerun reports no errno of its own
        stream = rr.RecordingStream(application(title))
        views = rrb.Vertical(*(rrb.Horizontal(*(chart.view() for chart in row)) for row in rows))
        tabs = rrb.Tabs(*(rrb.TextDocumentView(origin=_entity(name), name=name) for name in texts))
        layout = rrb.Vertical(views, tabs, row_shares=(4, 1))
        stream.save(path, default_blueprint=rrb.Blueprint(layout, collapse_panels=True))
        stream.send_recording_name(title)
        for row in rows:
            for chart in row:
                chart.draw(stream)
        for name, text in texts.items():
            words = rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN)
            stream.log(_entity(name), words, static=True)
        stream.flush(timeout_sec=FLUSH_SECONDS)
        stream.disconnect()
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise SlipmodeError(f"{path}: cannot be written: {reason}") from error


def _entity(name: str) -> str:
    return f"/texts/{rr.escape_entity_path_part(name)}"


def _span(axis: Axis, values: Sequence[Floats], from_zero: bool) -> tuple[float, float]:
    """Return the least and largest value that are shown."""
    if axis.names:
        return -0.5, len(axis.names) - 0.5
    all_of = np.concatenate(values)
    finite = all_of[np.isfinite(all_of)]
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if from_zero and low >= 0.0:
        low = 0.0
    if low == high:
        low, high = low - 0.05 * abs(low), high + 0.05 * abs(high)
    return (low, high) if low < high else (low, low + 1.0)


def _part(values: Floats, span: tuple[float, float], log: bool) -> Floats:
    """Return where values are on a scale, from 0 to 1."""
    low, high = np.log(span) if log else span
    return np.asarray(((np.log(values) if log else values) - low) / (high - low))


def _ticks(axis: Axis, span: tuple[float, float]) -> list[tuple[float, str]]:
    """Return round values in a span, or the names of values."""
    if axis.names:
        return list(enumerate(axis.names))
    low, high = span
    if axis.log:
        powers = range(floor(log10(low)), ceil(log10(high)) + 1)
        factors = (1.0, 2.0, 5.0) if len(powers) <= 5 else (1.0,)
        found = [m * 10.0**power for power in powers for m in factors]
        inside = [v for v in found if low * (1.0 - 1e-9) <= v <= high * (1.0 + 1e-9)]
        return [(v, f"{v:.4g}") for v in inside[:: len(inside) // 12 + 1]]
    least = (high - low) / 4
    unit = 10.0 ** floor(log10(least))
    step = next(unit * m for m in (1.0, 2.0, 5.0, 10.0) if unit * m >= least * 0.999)
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return [(k * step, f"{k * step:.6g}") for k in range(first, last + 1)]


def _strips(points: Floats) -> list[Floats]:
    """Curves between what is missing."""
    there = np.isfinite(points).all(axis=1)
    ends = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(int)))
    return [points[a:b] for a, b in ends.reshape(-1, 2).tolist() if b - a > 1]
