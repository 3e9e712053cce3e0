"""Showing a recording in Rerun."""

from __future__ import annotations

import tempfile
from pathlib import Path

from rom.errors import SlipmodeError
from runner.load import RecordingData, read
from runner.mcapfile.source import naming
from runner.rerun_sink import RerunSink
from runner.screenshot import photograph
from runner.selection import Selection
from runner.viewer import Viewer, find_viewer
from runner.views import Playing

_EVERYTHING = Selection()


def replay(
    path: str | Path,
    save: str | Path | None = None,
    screenshot: str | Path | None = None,
    selection: Selection = _EVERYTHING,
    playing: Playing | None = None,
) -> None:
    """Show an MCAP recording in Rerun, as the run itself would have shown it.

    Parameters
    ----------
    path : path
        An MCAP file written by slipmode.
    save : path, optional
        Write an .rrd file, views included, instead of opening the viewer.
    screenshot : path, optional
        Write a PNG of all views at the end of what is shown, without a window.
    selection : Selection
        Which channels and times to show.
    playing : Playing, optional
        Speed and repetition, also of the .rrd file when it is opened.

    Raises
    ------
    SlipmodeError
        If `path` cannot be read or has no such part, or no viewer can be started.
    OSError
        If `save` or `screenshot` cannot be written.
    """
    data = read(path)
    with naming(path):
        data = selection.of(data)
    if save is not None:
        _convert(data, Path(save), playing)
    if screenshot is not None:
        with tempfile.TemporaryDirectory() as folder:
            rrd = Path(folder) / "recording.rrd"
            _convert(data, rrd, None)
            picture = photograph(rrd, data.end_time)
        Path(screenshot).write_bytes(picture)
    if save is None and screenshot is None:
        _convert(data, _window(), playing)


def _window() -> Viewer:
    try:
        return find_viewer()
    except SlipmodeError as error:
        raise SlipmodeError(f"{error}; --save and --screenshot need no window") from error


def _convert(data: RecordingData, target: Path | Viewer, playing: Playing | None) -> None:
    channels = [channel for channel, _, _ in data.channels.values()]
    with RerunSink(target, data.header, channels, playing) as sink:
        for topic, (_, time, values) in data.channels.items():
            sink.write(topic, time, values)
        for event in data.events:
            sink.event(event.time, event.level, event.message)
