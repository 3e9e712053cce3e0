"""Charts and texts as an .rrd file, with the layout in which Rerun opens it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.recording.record import create_file
from slipmode.runner.view.charts.chart import Chart

_CHARTS, _TEXTS = 4, 1  # shares of the height
_FLUSH_TIMEOUT = 60.0  # [s]


def write_charts(
    path: Path, title: str, rows: Sequence[Sequence[Chart]], texts: Mapping[str, str]
) -> None:
    """Write rows of charts, and beneath them texts (Markdown) by their names, in tabs.

    Raises
    ------
    SlipmodeError
        If the file cannot be written.
    """
    try:
        create_file(path).close()  # Rerun reports no errno of its own
        stream = rr.RecordingStream(f"slipmode {title}")
        views = rrb.Vertical(*(rrb.Horizontal(*map(_view, row)) for row in rows))
        tabs = rrb.Tabs(*(rrb.TextDocumentView(origin=_entity(name), name=name) for name in texts))
        layout = rrb.Vertical(views, tabs, row_shares=(_CHARTS, _TEXTS))
        stream.save(path, default_blueprint=rrb.Blueprint(layout, collapse_panels=True))
        stream.send_recording_name(title)
        for row in rows:
            for chart in row:
                chart.draw(stream)
        for name, text in texts.items():
            words = rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN)
            stream.log(_entity(name), words, static=True)
        stream.flush(timeout_sec=_FLUSH_TIMEOUT)
        stream.disconnect()
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise SlipmodeError(f"{path}: cannot be written: {reason}") from error


def _entity(name: str) -> str:
    return f"/texts/{rr.escape_entity_path_part(name)}"


def _view(chart: Chart) -> rrb.View:
    x, y = chart.bounds
    return rrb.Spatial2DView(
        origin=chart.entity,
        name=chart.title,
        visual_bounds=rrb.VisualBounds2D(x_range=x, y_range=y),
    )
