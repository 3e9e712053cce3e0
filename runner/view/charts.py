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
from slipmode.rom.storage.files import create_file
from slipmode.runner.view.drawing import draw_labels, draw_lines
from slipmode.runner.view.plots import BLUE, DARK, GREY, Color
from slipmode.runner.view.samples import Span
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


@frozen
class Box:
    """Two scales at the left and lower edge of a box, and places in it."""

    x: Axis
    y: Axis
    xs: Span
    ys: Span
    aspect: float = _ASPECT  # Width of the box, whose height is 1
    row: float = 0.11  # Height of a line of text

    def place(self, x: Floats, y: Floats) -> Floats:
        """Return the places (n, 2) of points (n,) in a 2D view, whose second axis points down."""
        across, up = _part(x, self.xs, self.x.log), _part(y, self.ys, self.y.log)
        return np.column_stack((self.aspect * across, -up))

    def draw(
        self, stream: rr.RecordingStream, entity: str, key: Sequence[tuple[str, Color]] = ()
    ) -> None:
        """Draw the scales, and names with their colours beside the box."""
        lines = [[(self.aspect, 0.0), (0.0, 0.0), (0.0, -1.0)]]
        row, labels = self.row, dict[tuple[float, ...], str]()  # each hangs below its place
        x_ticks, x_name = _ticks(self.x, self.xs)
        y_ticks, y_name = _ticks(self.y, self.ys)
        for value, text in x_ticks:
            at = self.aspect * float(_part(np.array(value), self.xs, self.x.log))
            lines.append([(at, 0.0), (at, 0.02)])
            labels[at, 0.06] = text
        for value, text in y_ticks:
            at = -float(_part(np.array(value), self.ys, self.y.log))
            lines.append([(-0.015, at), (0.0, at)])
            labels[-1.3 * row, at - 0.4 * row] = text
        labels[0.5 * self.aspect, 0.06 + row] = x_name
        labels[0.3 * self.aspect, -1.0 - 1.3 * row] = y_name
        colors = [GREY] * len(labels) + [color for _, color in key]
        beside = self.aspect + 2.2 * row
        labels |= {(beside, -1.0 + 0.85 * row * k): name for k, (name, _) in enumerate(key)}
        draw_lines(stream, f"{entity}/box", lines, DARK, 0.5)
        draw_labels(stream, entity, labels, colors)


def box_view(entity: str, title: str, width: float, row: float = 0.11) -> rrb.View:
    """Return the view of a box and its labels, and as much beside it as `width` leaves."""
    bounds = rrb.VisualBounds2D(
        x_range=(-2.7 * row, width + row), y_range=(-1.0 - 1.5 * row, 0.06 + 2.2 * row)
    )
    return rrb.Spatial2DView(origin=entity, name=title, visual_bounds=bounds)


@dataclass(frozen=True)
class Chart:
    """Layers over the same two scales."""

    entity: str  # Its path in Rerun, "/steady/A"
    title: str
    x: Axis
    y: Axis
    layers: Sequence[Layer]
    from_zero: bool = True  # Whether y begins at 0 where it is not logarithmic

    def view(self) -> rrb.View:
        """Return the view of the chart: its box and its labels."""
        named = any(layer.name for layer in self.layers)
        return box_view(self.entity, self.title, _ASPECT + 0.4 * named)

    def draw(self, stream: rr.RecordingStream) -> None:
        """Draw the layers, the box with its scales, and the key."""
        xs = span(self.x, [layer.x[np.isfinite(layer.y)] for layer in self.layers], False)
        heights = [layer.y for layer in self.layers]
        heights += [layer.top for layer in self.layers if layer.top is not None]
        box = Box(self.x, self.y, xs, span(self.y, heights, self.from_zero and not self.y.log))
        key = [(layer.name, layer.color) for layer in self.layers if layer.name]
        box.draw(stream, self.entity, key)
        for k, layer in enumerate(self.layers):
            edges = [layer.y] if layer.top is None else [layer.y, layer.top]
            curves = [box.place(layer.x, edge) for edge in edges]
            color, radius = layer.color, rr.Radius.ui_points(layer.width)
            marks: rr.LineStrips2D | rr.Points2D
            if layer.curve:
                strips = [strip for points in curves for strip in _strips(points)]
                marks = rr.LineStrips2D(strips, colors=color, radii=radius)
            else:
                seen = curves[0][np.isfinite(curves[0]).all(axis=1)]
                marks = rr.Points2D(seen, colors=color, radii=radius)
            stream.log(f"{self.entity}/layers/{k}", marks, static=True)


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


def span(axis: Axis, values: Sequence[Floats], from_zero: bool) -> Span:
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


def _part(values: Floats, span: Span, log: bool) -> Floats:
    """Return where values are on a scale, from 0 to 1."""
    low, high = np.log(span) if log else span
    return np.asarray(((np.log(values) if log else values) - low) / (high - low))


def _ticks(axis: Axis, span: Span) -> tuple[list[tuple[float, str]], str]:
    """Return round values in a span, or the names of values; and the label with their unit."""
    if axis.names:
        return list(enumerate(axis.names)), axis.label
    low, high = span
    if axis.log:
        powers = range(floor(log10(low)), ceil(log10(high)) + 1)
        factors = (1.0, 2.0, 5.0) if len(powers) <= 5 else (1.0,)
        found = [m * 10.0**power for power in powers for m in factors]
        inside = [v for v in found if low * (1.0 - 1e-9) <= v <= high * (1.0 + 1e-9)]
        return [(v, f"{v:.4g}") for v in inside[:: len(inside) // 12 + 1]], axis.label
    least = (high - low) / 4
    unit = 10.0 ** floor(log10(least))
    step = next(unit * m for m in (1.0, 2.0, 5.0, 10.0) if unit * m >= least * 0.8)
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    power = floor(log10(max(-low, high)))
    scale = 1.0 if -2 <= power < 5 else 10.0 ** (3 * (power // 3))
    label = axis.label if scale == 1.0 else axis.label.replace("[", f"[{scale:g} ")
    return [(k * step, f"{k * step / scale:.6g}") for k in range(first, last + 1)], label


def _strips(points: Floats) -> list[Floats]:
    """Curves between what is missing."""
    there = np.isfinite(points).all(axis=1)
    ends = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(int)))
    return [points[a:b] for a, b in ends.reshape(-1, 2).tolist() if b - a > 1]
