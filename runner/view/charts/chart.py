"""A chart: curves and points in a box with its scales, whatever their units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

import numpy as np
import rerun as rr

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import short_repr

Color = tuple[int, int, int]
BLUE, ORANGE, GREEN, PURPLE = (76, 159, 230), (240, 145, 60), (110, 190, 110), (205, 110, 190)
RED, GREY = (224, 82, 82), (145, 153, 165)  # readable on black and on white, as the others
_AXIS = (75, 80, 90)
_ASPECT = 1.6  # width of a box, heights are 1: views are wider than high
_TICKS = 4  # about so many on an axis
_KEY = 0.09  # height of a line of the key


@dataclass(frozen=True, eq=False)
class Layer:
    """Points of a chart, or curves through them.

    Attributes
    ----------
    x, y : (n,) ndarray
        NaN in y breaks a curve.
    color : tuple of int
    name : str
        In the key; none if empty.
    curve : bool
    width : float
        Of the curve or the points, in points of the screen.
    """

    x: Floats
    y: Floats
    color: Color = BLUE
    name: str = ""
    curve: bool = True
    width: float = 1.5

    __repr__ = short_repr


@dataclass(frozen=True)
class Axis:
    """A scale: what it is of, with its unit; names of the values 0, 1, ... if they are none."""

    label: str
    names: tuple[str, ...] = ()
    log: bool = False


@dataclass(frozen=True)
class Chart:
    """Layers over the same two scales.

    Attributes
    ----------
    entity : str
        Where it is drawn, "/steady/A".
    title : str
    x, y : Axis
    layers : sequence of Layer
    from_zero : bool
        Whether y begins at 0.
    """

    entity: str
    title: str
    x: Axis
    y: Axis
    layers: Sequence[Layer]
    from_zero: bool = True

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """What a view shows: the box and its labels."""
        return (-0.3, _ASPECT + 0.1), (-1.12, 0.24)

    def draw(self, stream: rr.RecordingStream) -> None:
        """Draw it, box, scales and key too."""
        xs = _span(self.x, [layer.x[np.isfinite(layer.y)] for layer in self.layers], False)
        ys = _span(self.y, [layer.y for layer in self.layers], self.from_zero)
        self._box(stream, xs, ys)
        for k, layer in enumerate(self.layers):
            x = _ASPECT * _part(layer.x, xs, self.x.log)
            points = np.column_stack([x, -_part(layer.y, ys, self.y.log)])
            color, radius = layer.color, rr.Radius.ui_points(layer.width)
            drawn: rr.LineStrips2D | rr.Points2D
            if layer.curve:
                drawn = rr.LineStrips2D(_strips(points), colors=color, radii=radius)
            else:
                seen = points[np.isfinite(points).all(axis=1)]
                drawn = rr.Points2D(seen, colors=color, radii=radius)
            stream.log(f"{self.entity}/layers/{k}", drawn, static=True)

    def _box(
        self, stream: rr.RecordingStream, xs: tuple[float, float], ys: tuple[float, float]
    ) -> None:
        lines = [[(_ASPECT, 0.0), (0.0, 0.0), (0.0, -1.0)]]
        labels: list[tuple[float, float, str, Color]] = []
        for value, text in _ticks(self.x, xs):
            at = _ASPECT * float(_part(np.array(value), xs, self.x.log))
            lines.append([(at, 0.0), (at, 0.02)])
            labels.append((at, 0.08, text, GREY))
        for value, text in _ticks(self.y, ys):
            at = -float(_part(np.array(value), ys, self.y.log))
            lines.append([(-0.015, at), (0.0, at)])
            labels.append((-0.13, at, text, GREY))
        labels.append((0.5 * _ASPECT, 0.19, self.x.label, GREY))
        labels.append((0.3, -1.08, self.y.label, GREY))
        named = [layer for layer in self.layers if layer.name]
        for k, layer in enumerate(named):
            labels.append((_ASPECT - 0.25, -1.0 + k * _KEY, layer.name, layer.color))
        axes = rr.LineStrips2D(lines, colors=_AXIS, radii=rr.Radius.ui_points(0.5))
        stream.log(f"{self.entity}/box", axes, static=True)
        texts = rr.Points2D(
            [(x, y) for x, y, *_ in labels],
            labels=[text for *_, text, _ in labels],
            colors=[color for *_, color in labels],
            show_labels=True,
            radii=rr.Radius.ui_points(0.5),
        )
        stream.log(f"{self.entity}/labels", texts, static=True)


def _span(axis: Axis, values: Sequence[Floats], from_zero: bool) -> tuple[float, float]:
    """Least and largest value that are shown."""
    if axis.names:
        return -0.5, len(axis.names) - 0.5
    all_of = np.concatenate([np.ravel(v) for v in values])
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
    """Of the way from one end of a scale to the other."""
    low, high = np.log(span) if log else span
    return np.asarray(((np.log(values) if log else values) - low) / (high - low))


def _ticks(axis: Axis, span: tuple[float, float]) -> list[tuple[float, str]]:
    """Round values in a span, or the names of values."""
    if axis.names:
        return list(enumerate(axis.names))
    low, high = span
    if axis.log:
        powers = range(floor(log10(low)), ceil(log10(high)) + 1)
        many = powers.stop - powers.start > _TICKS + 1
        found = [
            m * 10.0**power for power in powers for m in ((1.0,) if many else (1.0, 2.0, 5.0))
        ]
        inside = [v for v in found if low * (1.0 - 1e-9) <= v <= high * (1.0 + 1e-9)]
        return [(v, f"{v:.4g}") for v in inside[:: len(inside) // (3 * _TICKS) + 1]]
    least = (high - low) / _TICKS
    unit = 10.0 ** floor(log10(least))
    step = next(unit * m for m in (1.0, 2.0, 5.0, 10.0) if unit * m >= least * 0.999)
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return [(k * step, f"{k * step:.6g}") for k in range(first, last + 1)]


def _strips(points: Floats) -> list[Floats]:
    """Curves between what is missing."""
    there = np.isfinite(points).all(axis=1)
    ends = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(int)))
    return [points[a:b] for a, b in ends.reshape(-1, 2).tolist() if b - a > 1]
