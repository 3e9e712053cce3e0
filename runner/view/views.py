"""Views of a recording in Rerun: plots with units, texts, and their layout."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.channels import EVENTS, FULL, OTHER, Channel, Event
from slipmode.runner.view import plots
from slipmode.runner.view.drawing import TIMELINE, time_column
from slipmode.runner.view.labels import readable_scale
from slipmode.runner.view.phase_portraits import FinalViews, view_of
from slipmode.runner.view.samples import Window
from slipmode.runner.view.spatial.drawings import drawings

_LISTED_EVENTS = "/listed_events"
_MOST_EVENTS = 500  # in one text: more are in the text log alone
_MOST_NAMED = 8  # names that a legend beside a plot of 110 pixels has room for at most


@dataclass(frozen=True)
class Playing:
    """How a viewer plays a recording once it has opened it."""

    speed: float = 1.0  # Simulated seconds per second
    loop: bool = False  # Whether it begins again at the end

    def __post_init__(self) -> None:
        if not 0.0 < self.speed < math.inf:
            raise SlipmodeError(f"speed must be > 0 and finite, got {self.speed:g}")


def _entity(found: plots.Curves) -> str:
    """Return the entity path of the curves of a plot."""
    path = f"{found.channel.topic}/{found.name}".removesuffix("/")
    return "/".join(map(rr.escape_entity_path_part, path.split("/")))


def send_series(
    stream: rr.RecordingStream, channel: Channel, time_ns: NDArray[np.int64], values: Floats
) -> None:
    """Append samples, values of shape (n, n_fields), to the plots of a channel."""
    index = [time_column(time_ns)]
    for found in plots.curves(channel):
        columns = rr.Scalars.columns(scalars=values[:, found.columns])
        stream.send_columns(_entity(found), index, columns)


def send_event(stream: rr.RecordingStream, events: Sequence[Event]) -> None:
    """Append the last event to the text log, and to the text that wraps long lines."""
    last = events[-1]
    level = "WARN" if last.level == "warning" else last.level.upper()
    stream.set_time(TIMELINE, duration=last.time)
    stream.log(EVENTS, rr.TextLog(_line(last), level=level))
    if len(events) <= _MOST_EVENTS:
        _write(stream, _LISTED_EVENTS, "\n\n".join(map(_line, events)))


def _line(event: Event) -> str:
    level = "" if event.level == "info" else f"**{event.level}**: "
    return f"{event.time:.6g} s: {level}{event.message}"


def describe(stream: rr.RecordingStream, channels: Sequence[Channel], scene_text: str) -> None:
    """Write what does not change: legends with units, explanations, and the scene if there is."""
    _name_series(stream, channels)
    explain(stream, channels)
    if scene_text:
        _write(stream, "/scene", f"```toml\n{scene_text}\n```")


def _write(stream: rr.RecordingStream, entity: str, markdown: str) -> None:
    text = rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN)
    stream.log(entity, text, static=True)


def _name_series(stream: rr.RecordingStream, listed: Sequence[Channel]) -> None:
    """Write names, colours and widths of all series."""
    compared = any(channel.topic.startswith(FULL) for channel in listed)
    for channel in listed:
        # A wide line of the reduced motion shows beneath the thin one of the full-order motion.
        width = 6.0 if compared and not channel.topic.startswith(FULL) else 1.5
        shift = int(channel.topic.split("/")[-1]) if plots.is_contact(channel) else 0
        shift += 2 * channel.topic.startswith(FULL)
        for found in plots.curves(channel):
            count = len(found.columns)
            colors = [plots.LINES[(shift + j) % len(plots.LINES)] for j in range(count)]
            style = rr.SeriesLines(
                names=found.names,
                colors=None if channel.topic.startswith(OTHER) else colors,
                widths=[width] * len(colors),
                aggregation_policy=rr.components.AggregationPolicy.MinMax,  # means hide cycles
            )
            stream.log(_entity(found), style, static=True)


def explain(
    stream: rr.RecordingStream, channels: Sequence[Channel], final: FinalViews | None = None
) -> None:
    """Write the explanations of the views of the channels; `final` as for `blueprint`."""
    titles = [portrait.title for portrait in _shown_portraits(channels, final)]
    titles += [drawing.title for drawing in drawings(channels)]
    _write(stream, "/reading", plots.reading(channels, titles))


def _shown_portraits(
    channels: Sequence[Channel], final: FinalViews | None
) -> list[plots.Portrait]:
    return [
        portrait
        for portrait in plots.portraits(channels)
        if (portrait.kind != "response" if final is None else portrait.entity in final.entities)
    ]


def _in_rows(groups: Iterable[list[rrb.View]]) -> list[list[rrb.View]]:
    """Return up to four rows of two views, or one row for each group if these were more."""
    groups = [group for group in groups if group]
    pairs = [group[k : k + 2] for group in groups for k in range(0, len(group), 2)]
    return pairs if len(pairs) <= 4 else groups


def blueprint(
    channels: Sequence[Channel], final: FinalViews | None = None, playing: Playing | None = None
) -> rrb.Blueprint:
    """Return the layout of the views of the channels that are recorded.

    `final` is what `Paths.draw` returns; without it, all portraits but responses and all fast
    motion are shown. Without `playing` a viewer does not play it by itself.
    """
    shown = _shown_portraits(channels, final)

    def of_kind(kind: str) -> list[rrb.View]:
        return [view_of(each) for each in shown if each.kind == kind]

    motion = _motion(channels, final)
    right, beneath = of_kind("plane"), of_kind("trajectory")
    if len(motion) > 5:  # plots of fast motion above the portrait, which would be too small
        right, beneath = [*right, *beneath], []
    kinds = ("response", "loop", "full loop", "orbit")
    rows: list[rrb.View | rrb.Container] = [
        rrb.Horizontal(*row) for row in _in_rows((right, *map(of_kind, kinds)))
    ]
    rows += [each.view() for each in drawings(channels) if not each.slow]
    columns: list[tuple[int, Sequence[rrb.View | rrb.Container]]] = [
        (16, _others(channels)),
        (6, _slow(channels, final)),
        (5, [*motion, *beneath]),
        (6, rows),
    ]
    filled = [(share, rrb.Vertical(*views)) for share, views in columns if views]
    layout: rrb.Container = _texts(channels)
    if filled:
        shares, contents = zip(*filled, strict=True)
        columns_ = rrb.Horizontal(*contents, column_shares=shares)
        layout = rrb.Vertical(columns_, layout, row_shares=(5, 1))
    plays: dict[str, Any] = {}
    if playing is not None:
        loop = "all" if playing.loop else "off"
        plays = {"play_state": "playing", "playback_speed": playing.speed, "loop_mode": loop}
    time_panel = rrb.TimePanel(timeline=TIMELINE, state="collapsed", **plays)
    return rrb.Blueprint(layout, time_panel, collapse_panels=True)


def _slow(channels: Sequence[Channel], final: FinalViews | None) -> list[rrb.View | rrb.Container]:
    """Return the plots of slow time; amplitudes of blades as a map, once they are complete."""
    maps = [each for each in drawings(channels) if each.slow and final]
    others = [each for each in channels if not any(each.topic in map_.topics for map_ in maps)]
    window = final.extents.times if final else None
    slow = _plots(others, final, fast=False, window=window)
    return [*(map_.view() for map_ in maps), *slow]


def _motion(
    channels: Sequence[Channel], final: FinalViews | None
) -> list[rrb.View | rrb.Container]:
    """Return the plots of fast motion; each of several windows has a tab of its own."""
    windows: Sequence[Window | None] = final.windows if final else ()
    whole = final.extents.times if final else None
    tabs = [_plots(channels, final, fast=True, window=window) for window in windows or (whole,)]
    if len(tabs) < 2:
        return tabs[0]
    names = [" to ".join(f"{time * 1e-9:.6g}" for time in window or ()) for window in windows]
    parts = [rrb.Vertical(*tab, name=f"{n} s") for tab, n in zip(tabs, names, strict=True)]
    return [rrb.Tabs(*parts, active_tab=len(parts) - 1)]


def _texts(channels: Sequence[Channel]) -> rrb.Container:
    """Return the events, and tabs of the explanations and the scene."""
    events = rrb.TextDocumentView(origin=_LISTED_EVENTS, name="Events")
    if any(channel.topic.startswith(OTHER) for channel in channels):
        return rrb.Horizontal(events)
    documents = rrb.Tabs(
        rrb.TextDocumentView(origin="/reading", name="How to read this"),
        rrb.TextDocumentView(origin="/scene", name="Scene"),
    )
    return rrb.Horizontal(events, documents, column_shares=(3, 2))


def _others(channels: Sequence[Channel]) -> list[rrb.Container]:
    """Return the plots of an external recording, one for each of its channels."""
    sources: dict[str, list[str]] = {}
    for channel in channels:
        if channel.topic.startswith(OTHER):
            entities = [_entity(found) for found in plots.curves(channel)]
            sources.setdefault(channel.description, []).extend(entities)
    views = [
        rrb.TimeSeriesView(name=source, contents=entities, plot_legend=rrb.Corner2D.LeftTop)
        for source, entities in sources.items()
    ]
    return [rrb.Grid(*views)] if views else []


def _plots(
    channels: Sequence[Channel], final: FinalViews | None, *, fast: bool, window: Window | None
) -> list[rrb.View | rrb.Container]:
    """Return the plots of what is recorded, over a window or the whole time.

    One curve has no legend, because the title names it. A few have one to the right of them, for
    which all plots have room, so that they end at the same time.
    """
    boundary = rr.TimeRangeBoundary
    places: dict[str, list[rrb.View]] = {}
    listed = plots.find_plots(channels, fast=fast)
    legends = [1 < sum(len(each.columns) for each in found) <= _MOST_NAMED for _, found in listed]
    ends = [boundary.infinite()] * 2
    if window:
        start, end = window
        room = (end - start) // 2 if any(legends) else 0
        ends = [boundary.absolute(nanos=time) for time in (start, end + room)]
    for (plot, found), several in zip(listed, legends, strict=True):
        parts = [(each.channel.topic, each.columns) for each in found]
        scale = readable_scale(*final.extents.over(parts)) if final else None
        view = rrb.TimeSeriesView(
            name=plots.titled(plot, found),
            contents=[_entity(each) for each in found],
            axis_x=rrb.TimeAxis(view_range=rr.TimeRange(*ends)),
            axis_y=rrb.ScalarAxis(range=scale) if scale else None,
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop, visible=several),
        )
        places.setdefault(plot.tab or f"{plot.topic}/{plot.name}", []).append(view)
    return [rrb.Tabs(*views) if len(views) > 1 else views[0] for views in places.values()]
