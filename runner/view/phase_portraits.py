"""One recorded quantity drawn against another: phase portraits, trajectories, hysteresis loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import FULL, PHASES, TORUS, Channel
from slipmode.runner.view import torus_view
from slipmode.runner.view.envelope import DENSE_SAMPLES
from slipmode.runner.view.layout.readable import readable
from slipmode.runner.view.layout.stretches import Stretches, Window, stretch_starts
from slipmode.runner.view.tail import tails

TIMELINE = "time"
PHASE_PORTRAIT, TRAJECTORY, LOOP, ORBIT = "/phase_plane", "/trajectory", "/loop", "/orbit"
RESPONSE = "/response"
AXIS_REACH = 1.3  # half the width of a portrait, in units of the largest value
COLORS = [(76, 159, 230), (240, 145, 60), (110, 190, 110), (205, 110, 190), (200, 190, 90)]
_PATH_COLOR, _AXIS_COLOR = (110, 125, 145), (75, 80, 90)
_LABEL_COLOR = _POINT_COLOR = (145, 153, 165)  # readable on black and on white

_LOOPS = 3  # of the first contacts: more would be too small to read
# of a channel, to draw paths from; a viewer without a GPU slows down with more
_KEPT_SAMPLES = 8192
_MOVING_POINTS = 1000  # positions of the point that moves along a path
_TAIL_SAMPLES = 96  # a period and a half of contact motion, at the usual sampling
_ELASTIC, _FIRST = "/elastic", "/contact/0"
_SWEPT = 1e-6  # of a frequency: what changes less is no sweep


@dataclass(frozen=True)
class Axis:
    """A recorded quantity as the axis of a portrait: channel, field and what to call it."""

    topic: str
    field: str
    label: str
    unit: str


@dataclass(frozen=True)
class Portrait:
    """One recorded quantity drawn against another.

    Parameters
    ----------
    entity : str
        Where it is drawn.
    title : str
        What it shows.
    x, y : Axis
        The two quantities, y upwards.
    one_scale : bool
        Whether both axes share a scale, so that angles are true.
    tail : int
        Length of the moving point's tail, in samples.
    corner : bool
        Whether the axes meet in the corner, x from its least value and y from 0.
    """

    entity: str
    title: str
    x: Axis
    y: Axis
    one_scale: bool
    tail: int
    corner: bool = False

    def is_drawn(self, path: Floats) -> bool:
        """Whether its values, (n, 2), make a picture: a frequency that stays makes none."""
        if not self.corner:
            return len(path) > 0
        return len(path) > 1 and bool(np.ptp(path[:, 0]) > _SWEPT * path[:, 0].max())

    def placed(self, path: Floats) -> tuple[Floats, dict[tuple[float, float], str]]:
        """Where values, (n, 2), are drawn, from -1 to 1, and the marks on the axes."""
        if self.corner:
            low, high = path[:, 0].min(), path[:, 0].max()
            top = path[:, 1].max() or 1.0
            marks = {
                (-1.0, -1.0): f"{low:.4g}",
                (1.0, -1.0): f"{high:.4g} {self.x.unit}",
                (-1.0, 1.0): f"{self.y.label} = {readable(top, self.y.unit)}",
            }
            return 2.0 * (path - (low, 0.0)) / (high - low, top) - 1.0, marks
        scale = np.abs(path).max(axis=0)
        if self.one_scale:
            scale[:] = scale.max()
        scale[scale == 0.0] = 1.0
        x, y = (
            f"{axis.label} = {readable(largest, axis.unit)}"
            for axis, largest in zip((self.x, self.y), scale.tolist(), strict=True)
        )
        return path / scale, {(1.0, 0.0): self.x.label if self.one_scale else x, (0.0, 1.0): y}


@dataclass(frozen=True)
class Drawn:
    """What portraits turned out: which there are, and the windows of motion they show."""

    entities: tuple[str, ...]
    windows: tuple[Window, ...]


def portraits(channels: Iterable[Channel]) -> list[Portrait]:
    """Phase portraits of the modes, the contact trajectory, the first hysteresis loops.

    And the orbits of these contacts in their planes, where they slide in two directions; and the
    amplitudes of the modes against their frequencies, which make a picture in sweeps.
    """
    by_topic = {channel.topic: channel for channel in channels}
    contacts = [topic for topic in by_topic if topic.startswith("/contact/")]

    def axis(topic: str, field: str, label: str) -> Axis:
        units = {field.name: field.unit for field in by_topic[topic].fields}
        return Axis(topic, field, label, units[field])

    found = [
        Portrait(
            f"{PHASE_PORTRAIT}/{mode}",
            f"Mode {mode}",
            axis("/modes", f"{mode}_re", f"Re {mode}"),
            axis("/modes", f"{mode}_im", f"Im {mode}"),
            one_scale=True,
            tail=0,
        )
        for mode in "AB"
        if "/modes" in by_topic and f"{mode}_re" in by_topic["/modes"].names
    ]
    found += [
        Portrait(
            f"{RESPONSE}/{mode}",
            f"|{mode}| over its frequency",
            axis("/forcing", f"{mode}_frequency", "frequency"),
            axis("/modes", f"{mode}_abs", f"|{mode}|"),
            one_scale=False,
            tail=0,
            corner=True,
        )
        for mode in "AB"
        if {"/modes", "/forcing"} <= by_topic.keys()
        and f"{mode}_abs" in by_topic["/modes"].names
        and f"{mode}_frequency" in by_topic["/forcing"].names
    ]
    if len(contacts) > 1:
        x, y = (axis(topic, "x", f"x_{topic.split('/')[-1]}") for topic in contacts[:2])
        found.append(Portrait(TRAJECTORY, "Contacts", x, y, False, _TAIL_SAMPLES))
    full = [topic for topic in by_topic if topic.startswith(f"{FULL}/contact/")]
    for topic in (*contacts[:_LOOPS], *full[:_LOOPS]):
        title = f"Hysteresis of contact {topic.split('/')[-1]}"
        title += ", full order" if topic in full else ""
        x, y = axis(topic, "x", "x"), axis(topic, "f", "f")
        found.append(Portrait(f"{LOOP}{topic}", title, x, y, False, _TAIL_SAMPLES))
        if "y" in by_topic[topic].names:
            title = title.replace("Hysteresis", "Orbit")
            plane = axis(topic, "x", "x"), axis(topic, "y", "y")
            found.append(Portrait(f"{ORBIT}{topic}", title, *plane, True, _TAIL_SAMPLES))
    return found


class Paths:
    """Samples of the quantities that portraits show, kept until their scales are known.

    Memory is bounded: beyond some thousand samples of a channel every other one is dropped, or,
    of fast motion, which would lose its shape, all but the latest.
    """

    def __init__(self, channels: Sequence[Channel]) -> None:
        self._portraits = portraits(channels)
        self._channels = {channel.topic: channel for channel in channels}
        self._samples: dict[str, _Thinned | _Latest] = {
            axis.topic: _Latest() if portrait.tail else _Thinned()
            for portrait in self._portraits
            for axis in (portrait.x, portrait.y)
        }
        if _ELASTIC in self._channels:
            self._samples[_ELASTIC] = _Latest()
        if torus_view.has_torus(channels):
            self._samples |= {topic: _Latest() for topic in (PHASES, TORUS)}

    def extend(self, topic: str, time_ns: NDArray[np.int64], values: Floats) -> None:
        """Keep samples of a channel that some portrait shows, or that tells where motion is."""
        if topic in self._samples:
            self._samples[topic].extend(np.column_stack([time_ns, values]))

    def draw(self, stream: rr.RecordingStream) -> Drawn:
        """Draw every portrait that has samples."""
        entities, motion = [], ""
        for portrait in self._portraits:
            time_ns, path = self._path(portrait)
            if not portrait.is_drawn(path):
                continue
            entities.append(portrait.entity)
            points, marks = portrait.placed(path)
            _draw_axes(stream, portrait, marks)
            # Rerun's second coordinate points down.
            _draw_path(stream, portrait, time_ns, points * (1.0, -1.0))
            if portrait.tail:
                motion = portrait.x.topic
        self._draw_torus(stream)
        if not motion and _ELASTIC in self._samples:
            motion = _ELASTIC
        shown = self._samples.get(motion)
        windows: list[Window] = []
        if isinstance(shown, _Latest) and shown.seen <= DENSE_SAMPLES:
            windows = shown.stretches.windows()
        return Drawn(tuple(entities), tuple(windows))

    def _draw_torus(self, stream: rr.RecordingStream) -> None:
        """Draw contact motion over both phases, of the last window."""
        if TORUS not in self._samples:
            return
        torus, phases, motion = (self._samples[topic].rows() for topic in (TORUS, PHASES, _FIRST))
        if not (len(torus) and len(phases) and len(motion)):
            return
        count = min(len(phases), len(motion))
        phases, motion = phases[-count:], motion[-count:]
        last = stretch_starts(motion[:, 0].astype(np.int64))[-1]
        phases, motion = phases[last:, 1:], motion[last:]
        shown = _shown(len(motion))
        index = [time_column(motion[shown, 0].astype(np.int64))]
        field = self._channels[_FIRST].names.index("x")
        x, unit = motion[:, 1 + field], self._channels[_FIRST].fields[field].unit
        latest = torus[torus[:, 0] == torus[-1, 0], 1:]
        torus_view.draw(stream, latest, phases, x, unit, index, shown, _TAIL_SAMPLES)

    def _path(self, portrait: Portrait) -> tuple[NDArray[np.int64], Floats]:
        """Times and points, shape (n, 2), of samples that both axes have."""
        samples = [self._samples[axis.topic].rows() for axis in (portrait.x, portrait.y)]
        count = min(len(kept) for kept in samples)
        if count == 0:
            return np.empty(0, np.int64), np.empty((0, 2))
        columns = [
            kept[:count, 1 + self._channels[axis.topic].names.index(axis.field)]
            for axis, kept in zip((portrait.x, portrait.y), samples, strict=True)
        ]
        return samples[0][:count, 0].astype(np.int64), np.column_stack(columns)


class _Latest:
    """The latest rows of time and values."""

    def __init__(self) -> None:
        self.seen = 0
        self.stretches = Stretches()
        self._rows = np.empty((0, 0))

    def extend(self, rows: Floats) -> None:
        self.seen += len(rows)
        self.stretches.extend(rows[:, 0].astype(np.int64))
        kept = [self._rows, rows] if len(self._rows) else [rows]
        self._rows = np.concatenate(kept)[-_KEPT_SAMPLES:].copy()

    def rows(self) -> Floats:
        return self._rows


class _Thinned:
    """Rows of time and values, thinned evenly when they become too many."""

    def __init__(self) -> None:
        self.seen = 0
        self._blocks: list[Floats] = []
        self._stride = 1
        self._kept = 0

    def extend(self, rows: Floats) -> None:
        block = rows[-self.seen % self._stride :: self._stride]
        self._blocks.append(block)
        self.seen += len(rows)
        self._kept += len(block)
        while self._kept > _KEPT_SAMPLES:
            self._blocks = [self.rows()[::2].copy()]
            self._kept = len(self._blocks[0])
            self._stride *= 2

    def rows(self) -> Floats:
        return np.concatenate(self._blocks) if self._blocks else np.empty((0, 0))


def _draw_axes(
    stream: rr.RecordingStream, portrait: Portrait, marks: dict[tuple[float, float], str]
) -> None:
    at = 1.0 if portrait.corner else 0.0
    low = -1.0 if portrait.corner else -AXIS_REACH
    ends = [[(low, at), (AXIS_REACH, at)], [(-at, -low), (-at, -AXIS_REACH)]]
    axes = rr.LineStrips2D(
        ends, colors=_AXIS_COLOR, radii=rr.Radius.ui_points(0.5), draw_order=0.0
    )
    stream.log(f"{portrait.entity}/axes", axes, static=True)
    labels = rr.Points2D(
        [(x, -y) for x, y in marks],
        labels=list(marks.values()),
        show_labels=True,
        colors=_LABEL_COLOR,
        radii=rr.Radius.ui_points(2.5),
    )
    stream.log(f"{portrait.entity}/labels", labels, static=True)


def _draw_path(
    stream: rr.RecordingStream,
    portrait: Portrait,
    time_ns: NDArray[np.int64],
    points: Floats,
) -> None:
    """Whole path as a thin line, its recent part as a bright one, its end as a moving point."""
    color = COLORS[1] if portrait.entity.endswith(("B", "1")) else COLORS[0]
    starts = stretch_starts(time_ns)
    whole = rr.LineStrips2D(
        np.split(points, np.unique(starts)[1:]),
        colors=_PATH_COLOR if portrait.tail else color,
        radii=rr.Radius.ui_points(0.6 if portrait.tail else 1.5),
        draw_order=1.0,
    )
    stream.log(f"{portrait.entity}/path", whole, static=True)
    shown = _shown(len(points))
    index = [time_column(time_ns[shown])]
    if portrait.tail:
        strips = tails(points, starts, shown, portrait.tail)
        style = rr.LineStrips2D.from_fields(
            colors=color, radii=rr.Radius.ui_points(1.5), draw_order=2.0
        )
        stream.log(f"{portrait.entity}/tail", style, static=True)
        stream.send_columns(
            f"{portrait.entity}/tail", index, rr.LineStrips2D.columns(strips=strips)
        )
    mark = rr.Points2D.from_fields(
        colors=_POINT_COLOR, radii=rr.Radius.ui_points(5.0), draw_order=3.0
    )
    stream.log(f"{portrait.entity}/now", mark, static=True)
    stream.send_columns(
        f"{portrait.entity}/now", index, rr.Points2D.columns(positions=points[shown])
    )


def _shown(count: int) -> NDArray[np.int64]:
    """At which of some samples the moving point is shown."""
    return np.linspace(0, count - 1, min(count, _MOVING_POINTS)).astype(np.int64)


def time_column(time_ns: NDArray[np.int64]) -> rr.TimeColumn:
    """Simulation times [ns] on the recording's timeline."""
    return rr.TimeColumn(TIMELINE, duration=time_ns.astype("timedelta64[ns]"))
