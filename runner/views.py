"""What a recording looks like in Rerun: plots with units, drawn paths and loops, the layout."""

from __future__ import annotations

import shutil
import sysconfig
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from runner.channels import EVENTS, Channel, Level

TIMELINE = "time"
VIEWER = shutil.which("rerun", path=sysconfig.get_path("scripts"))  # also off the PATH

_SCENE = "/scene"
_PHASE_PLANE, _TRAJECTORY, _LOOP = "/phase_plane", "/trajectory", "/loop"
_LOOPS = 3  # of the first contacts: more would be too small to read
_KEPT_SAMPLES = 32768  # of a channel, to draw paths from
_MOVING_POINTS = 1000  # positions of the point that moves along a path
_TRAIL_SAMPLES = 96  # a period and a half of contact motion, at the usual sampling
_SHOWN_SAMPLES = 2048  # of contact motion at first: some thirty periods
_AXIS_REACH = 1.3  # half the width of a plane, in units of the largest value
_AXIS_LABEL = 1.15

_COLORS = [(76, 159, 230), (240, 145, 60), (110, 190, 110), (205, 110, 190), (200, 190, 90)]
_PATH_COLOR, _AXIS_COLOR = (110, 125, 145), (75, 80, 90)
_LABEL_COLOR = _POINT_COLOR = (230, 230, 230)

_LEVELS: Mapping[Level, rr.TextLogLevel] = {
    "info": rr.TextLogLevel.INFO,
    "warning": rr.TextLogLevel.WARN,
    "error": rr.TextLogLevel.ERROR,
}

# The last word of a field's name tells its quantity; fields of one quantity share a plot.
_QUANTITIES = {"re": "components", "im": "components", "abs": "amplitude"}
_QUANTITIES |= {"x": "displacement", "v": "velocity", "f": "friction_force"}

_SLOW_PLOTS = (
    ("/modes", "amplitude", "Modal amplitude"),
    ("/forcing", "force", "Force amplitude"),
    ("/forcing", "frequency", "Forcing frequency"),
    ("/energy", "power", "Power"),
    ("/energy", "energy", "Dissipated energy"),
)
_MOTION_PLOTS = (
    ("/elastic", "displacement", "Elastic displacement"),
    ("/contact", "displacement", "Contact displacement"),
    ("/contact", "friction_force", "Friction force"),
)


@dataclass(frozen=True)
class Extent:
    """How far a recording reaches, which is known only at its end.

    Parameters
    ----------
    scales : mapping of str to (float, float)
        Largest values on the axes of each plane, by its entity.
    window : tuple of int, optional
        First and last time of the contact motion to show at first [ns].
    """

    scales: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    window: tuple[int, int] | None = None


@dataclass(frozen=True)
class Axis:
    """A recorded quantity as the axis of a plane: channel, field and what to call it."""

    topic: str
    field: str
    label: str
    unit: str


@dataclass(frozen=True)
class Plane:
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
    trail : int
        How many samples trail the moving point.
    """

    entity: str
    title: str
    x: Axis
    y: Axis
    one_scale: bool
    trail: int

    def name(self, scales: tuple[float, float] | None) -> str:
        """Name of the view; the scales, once known, are the largest values on the axes."""
        if self.one_scale:
            return self.title if scales is None else f"{self.title} / {_quoted(scales[0], self.x)}"
        x, y = self.x.label, self.y.label
        if scales is not None:
            x += f" / {_quoted(scales[0], self.x)}"
            y += f" / {_quoted(scales[1], self.y)}"
        return f"{self.title}: {y} against {x}"


def planes(channels: Iterable[Channel]) -> list[Plane]:
    """Phase planes of the modes, the contact trajectory and the first hysteresis loops."""
    by_topic = {channel.topic: channel for channel in channels}
    contacts = [topic for topic in by_topic if topic.startswith("/contact/")]

    def axis(topic: str, field: str, label: str) -> Axis:
        units = {field.name: field.unit for field in by_topic[topic].fields}
        return Axis(topic, field, label, units[field])

    found = [
        Plane(
            f"{_PHASE_PLANE}/{mode}",
            f"Mode {mode}",
            axis("/modes", f"{mode}_re", f"Re {mode}"),
            axis("/modes", f"{mode}_im", f"Im {mode}"),
            one_scale=True,
            trail=0,
        )
        for mode in "AB"
        if "/modes" in by_topic and f"{mode}_re" in by_topic["/modes"].names
    ]
    if len(contacts) > 1:
        x, y = (axis(topic, "x", f"x_{topic.split('/')[-1]}") for topic in contacts[:2])
        found.append(Plane(_TRAJECTORY, "Contacts", x, y, False, _TRAIL_SAMPLES))
    for topic in contacts[:_LOOPS]:
        title = topic.strip("/").replace("/", " ")
        x, y = axis(topic, "x", "x"), axis(topic, "f", "f")
        found.append(Plane(f"{_LOOP}{topic}", title, x, y, False, _TRAIL_SAMPLES))
    return found


def _quoted(scale: float, axis: Axis) -> str:
    return f"{scale:.3g} {axis.unit}"


class Paths:
    """Samples of the quantities that planes show, kept until their scales are known.

    Memory is bounded: beyond some ten thousand samples of a channel every other one is dropped.
    """

    def __init__(self, channels: Sequence[Channel]) -> None:
        self._planes = planes(channels)
        self._channels = {channel.topic: channel for channel in channels}
        self._samples = {
            axis.topic: _Samples() for plane in self._planes for axis in (plane.x, plane.y)
        }

    def extend(self, topic: str, time_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Keep samples of a channel, if some plane shows it."""
        if topic in self._samples:
            self._samples[topic].extend(np.column_stack([time_ns, values]))

    def draw(self, stream: rr.RecordingStream) -> Extent:
        """Draw every plane that has samples; return how far they reach."""
        scales = {}
        window = None
        for plane in self._planes:
            time_ns, path = self._path(plane)
            if len(path) == 0:
                continue
            scale = np.abs(path).max(axis=0)
            if plane.one_scale:
                scale[:] = scale.max()
            scale[scale == 0.0] = 1.0
            _draw_axes(stream, plane)
            # Rerun's second coordinate points down.
            _draw_path(stream, plane, time_ns, path / scale * (1.0, -1.0))
            scales[plane.entity] = (float(scale[0]), float(scale[1]))
            if plane.trail:
                window = _latest_window(time_ns)
        return Extent(scales, window)

    def _path(self, plane: Plane) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Times and points, shape (n, 2), of samples that both axes have."""
        samples = [self._samples[axis.topic].rows() for axis in (plane.x, plane.y)]
        count = min(len(kept) for kept in samples)
        if count == 0:
            return np.empty(0, np.int64), np.empty((0, 2))
        columns = [
            kept[:count, 1 + self._channels[axis.topic].names.index(axis.field)]
            for axis, kept in zip((plane.x, plane.y), samples, strict=True)
        ]
        return samples[0][:count, 0].astype(np.int64), np.column_stack(columns)


class _Samples:
    """Rows of time and values, thinned evenly when they become too many."""

    def __init__(self) -> None:
        self._blocks: list[NDArray[np.float64]] = []
        self._stride = 1
        self._seen = 0
        self._kept = 0

    def extend(self, rows: NDArray[np.float64]) -> None:
        block = rows[-self._seen % self._stride :: self._stride]
        self._blocks.append(block)
        self._seen += len(rows)
        self._kept += len(block)
        while self._kept > _KEPT_SAMPLES:
            self._blocks = [self.rows()[::2].copy()]
            self._kept = len(self._blocks[0])
            self._stride *= 2

    def rows(self) -> NDArray[np.float64]:
        return np.concatenate(self._blocks) if self._blocks else np.empty((0, 0))


def _draw_axes(stream: rr.RecordingStream, plane: Plane) -> None:
    ends = [[(-_AXIS_REACH, 0.0), (_AXIS_REACH, 0.0)], [(0.0, _AXIS_REACH), (0.0, -_AXIS_REACH)]]
    axes = rr.LineStrips2D(
        ends, colors=_AXIS_COLOR, radii=rr.Radius.ui_points(0.5), draw_order=0.0
    )
    stream.log(f"{plane.entity}/axes", axes, static=True)
    labels = rr.Points2D(
        [(_AXIS_LABEL, 0.0), (0.0, -_AXIS_LABEL)],
        labels=[plane.x.label, plane.y.label],
        show_labels=True,
        colors=_LABEL_COLOR,
        radii=rr.Radius.ui_points(0.5),
    )
    stream.log(f"{plane.entity}/labels", labels, static=True)


def _draw_path(
    stream: rr.RecordingStream,
    plane: Plane,
    time_ns: NDArray[np.int64],
    points: NDArray[np.float64],
) -> None:
    """Whole path as a thin line, its recent part as a bright one, its end as a moving point."""
    color = _COLORS[1] if plane.entity.endswith(("B", "1")) else _COLORS[0]
    starts = _stretch_starts(time_ns)
    whole = rr.LineStrips2D(
        np.split(points, np.unique(starts)[1:]),
        colors=_PATH_COLOR if plane.trail else color,
        radii=rr.Radius.ui_points(0.6 if plane.trail else 1.5),
        draw_order=1.0,
    )
    stream.log(f"{plane.entity}/path", whole, static=True)
    shown = np.linspace(0, len(points) - 1, min(len(points), _MOVING_POINTS)).astype(int)
    index = [_time_column(time_ns[shown])]
    if plane.trail:
        trails = [points[max(starts[i], i + 1 - plane.trail) : i + 1] for i in shown]
        style = rr.LineStrips2D.from_fields(
            colors=color, radii=rr.Radius.ui_points(1.5), draw_order=2.0
        )
        stream.log(f"{plane.entity}/trail", style, static=True)
        stream.send_columns(f"{plane.entity}/trail", index, rr.LineStrips2D.columns(strips=trails))
    mark = rr.Points2D.from_fields(
        colors=_POINT_COLOR, radii=rr.Radius.ui_points(5.0), draw_order=3.0
    )
    stream.log(f"{plane.entity}/now", mark, static=True)
    stream.send_columns(f"{plane.entity}/now", index, rr.Points2D.columns(positions=points[shown]))


def _latest_window(time_ns: NDArray[np.int64]) -> tuple[int, int]:
    first = max(int(_stretch_starts(time_ns)[-1]), len(time_ns) - _SHOWN_SAMPLES)
    return int(time_ns[first]), int(time_ns[-1])


def _stretch_starts(time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each sample, where its unbroken stretch begins: windows are apart in time."""
    steps = np.diff(time_ns, prepend=time_ns[:1])
    breaks = steps > 10 * np.median(steps)
    return np.maximum.accumulate(np.where(breaks, np.arange(len(steps)), 0))


@dataclass(frozen=True)
class Series:
    """Columns of a channel that share a plot, with their names in the legend."""

    entity: str
    columns: tuple[int, ...]
    names: tuple[str, ...]


def series(channel: Channel) -> list[Series]:
    """Plots of a channel: one entity for each quantity."""
    columns: dict[str, list[int]] = {}
    for column, name in enumerate(channel.names):
        columns.setdefault(_quantity(name), []).append(column)
    return [
        Series(
            f"{channel.topic}/{quantity}",
            tuple(members),
            tuple(_legend(channel, column) for column in members),
        )
        for quantity, members in columns.items()
    ]


def _quantity(name: str) -> str:
    word = "x" if name.startswith("x_") else name.split("_")[-1]
    return _QUANTITIES.get(word, word)


def _legend(channel: Channel, column: int) -> str:
    field = channel.fields[column]
    mode, _, part = field.name.partition("_")
    if part == "abs":
        text = f"|{mode}|"
    elif mode in ("A", "B"):
        text = f"{part.capitalize()} {mode}"
    elif channel.topic.startswith("/contact/"):
        text = f"{field.name} contact {channel.topic.split('/')[-1]}"
    else:
        text = field.name.replace("_", " ") if "/energy" in channel.topic else field.name
    return f"{text} [{field.unit}]"


def send_series(
    stream: rr.RecordingStream,
    channel: Channel,
    time_ns: NDArray[np.int64],
    values: NDArray[np.float64],
) -> None:
    """Append samples, values of shape (n, n_fields), to the plots of a channel."""
    index = [_time_column(time_ns)]
    for plot in series(channel):
        columns = rr.Scalars.columns(scalars=values[:, plot.columns])
        stream.send_columns(plot.entity, index, columns)


def send_event(
    stream: rr.RecordingStream, time_ns: NDArray[np.int64], level: Level, message: str
) -> None:
    """Append a line to the text log."""
    columns = rr.TextLog.columns(text=[message], level=[_LEVELS[level]])
    stream.send_columns(EVENTS, [_time_column(time_ns)], columns)


def describe(stream: rr.RecordingStream, channels: Iterable[Channel], scene_text: str) -> None:
    """Write what does not change: legends with units, and the scene."""
    for channel in channels:
        shift = int(channel.topic.split("/")[-1]) if channel.topic.startswith("/contact/") else 0
        for plot in series(channel):
            colors = [_COLORS[(shift + j) % len(_COLORS)] for j in range(len(plot.names))]
            style = rr.SeriesLines(
                names=plot.names,
                colors=colors,
                widths=[1.5] * len(colors),
                aggregation_policy=rr.components.AggregationPolicy.MinMax,  # means hide cycles
            )
            stream.log(plot.entity, style, static=True)
    document = rr.TextDocument(f"```toml\n{scene_text}\n```", media_type=rr.MediaType.MARKDOWN)
    stream.log(_SCENE, document, static=True)


def blueprint(channels: Sequence[Channel], extent: Extent) -> rrb.Blueprint:
    """Layout of the views of the channels that are present.

    Parameters
    ----------
    channels : sequence of Channel
        What is recorded.
    extent : Extent
        How far they reach, as `Paths.draw` returns it; ``Extent()`` while unknown.
    """
    drawings = {plane.entity: _drawing(plane, extent) for plane in planes(channels)}

    def drawn(kind: str) -> list[rrb.View]:
        return [view for entity, view in drawings.items() if entity.startswith(kind)]

    motion = _plots(channels, _MOTION_PLOTS, extent.window) + drawn(_TRAJECTORY)
    rows = [rrb.Horizontal(*row) for row in (drawn(_PHASE_PLANE), drawn(_LOOP)) if row]
    texts = [
        rrb.TextDocumentView(origin=_SCENE, name="Scene"),
        rrb.TextLogView(
            origin=EVENTS,
            name="Events",
            columns=rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"]),
        ),
    ]
    columns = ((5, _plots(channels, _SLOW_PLOTS)), (4, motion), (7, rows), (4, texts))
    filled = [(share, rrb.Vertical(*views)) for share, views in columns if views]
    shares, contents = zip(*filled, strict=True)
    return rrb.Blueprint(
        rrb.Horizontal(*contents, column_shares=shares),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        collapse_panels=True,
    )


def _plots(
    channels: Sequence[Channel],
    wanted: Sequence[tuple[str, str, str]],
    window: tuple[int, int] | None = None,
) -> list[rrb.View]:
    """Plots of the wanted quantities that are recorded, over a window or else the whole time."""
    boundary = rr.TimeRangeBoundary
    if window is None:
        shown = rr.TimeRange(boundary.infinite(), boundary.infinite())
    else:
        shown = rr.TimeRange(*(boundary.absolute(nanos=time) for time in window))
    return [
        rrb.TimeSeriesView(
            name=title,
            contents=entities,
            axis_x=rrb.TimeAxis(view_range=shown),
            plot_legend=rrb.Corner2D.RightBottom,
        )
        for topic, quantity, title in wanted
        if (entities := _entities(channels, topic, quantity))
    ]


def _drawing(plane: Plane, extent: Extent) -> rrb.View:
    reach = (-_AXIS_REACH, _AXIS_REACH)
    return rrb.Spatial2DView(
        origin=plane.entity,
        name=plane.name(extent.scales.get(plane.entity)),
        visual_bounds=rrb.VisualBounds2D(x_range=reach, y_range=reach),
    )


def _entities(channels: Sequence[Channel], topic: str, quantity: str) -> list[str]:
    return [
        plot.entity
        for channel in channels
        if channel.topic == topic or channel.topic.startswith(f"{topic}/")
        for plot in series(channel)
        if plot.entity == f"{channel.topic}/{quantity}"
    ]


def _time_column(time_ns: NDArray[np.int64]) -> rr.TimeColumn:
    return rr.TimeColumn(TIMELINE, duration=time_ns.astype("timedelta64[ns]"))
