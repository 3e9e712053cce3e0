"""Replay of recordings in Rerun."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from slipmode.rom.errors import SlipmodeError, naming
from slipmode.runner.recording.external import as_curves, is_external, read_external
from slipmode.runner.recording.load import RecordingData, Selection, read
from slipmode.runner.view.viewer import Viewer, browser_viewer, find_viewer, write_picture

if TYPE_CHECKING:
    from slipmode.runner.view.views import Playing

_EVERYTHING = Selection()


def replay(
    path: str | Path,
    save: str | Path | None = None,
    screenshot: str | Path | None = None,
    selection: Selection = _EVERYTHING,
    playing: Playing | None = None,
) -> list[str]:
    """Show an MCAP recording in Rerun, as the run itself would have shown it.

    A damaged recording is shown up to its damage, of another program's recording the numbers.
    Returns a line for each part that is not shown. Raises SlipmodeError if `path` cannot be read
    or has no such part, or no viewer can be started; OSError if a file cannot be written.

    Parameters
    ----------
    path : path
        An MCAP file.
    save : path, optional
        Write an .rrd file, views included, instead of opening the viewer.
    screenshot : path, optional
        Write a PNG of all views at the end of the shown part, without a window.
    selection : Selection
        Which channels and times to show.
    playing : Playing, optional
        Speed and repetition, also of the .rrd file when it is opened.
    """
    data = read_external(path) if is_external(path) else read(path)
    notes = []
    if data.damage:
        notes.append(f"{path}: {data.missing('shown')}")
    if data.left_out:
        notes.append(f"{path}: not shown: {'; '.join(data.left_out)}")
    with naming(path):
        data = selection.of(data)
    if save is not None:
        _convert(data, Path(save), playing)
    if screenshot is not None:
        write_picture(screenshot, lambda rrd: _convert(data, rrd, None), data.end_time)
    if save is None and screenshot is None:
        try:
            viewer = find_viewer()
        except SlipmodeError as error:
            raise SlipmodeError(f"{error}; --save and --screenshot need no window") from error
        _convert(data, viewer, playing)
    return notes


@contextmanager
def in_browser(
    path: str | Path,
    selection: Selection = _EVERYTHING,
    playing: Playing | None = None,
    port: int = 0,
) -> Iterator[str]:
    """Serve an MCAP recording to browsers of this machine until the context ends.

    Yields the address of the page, at `port`, or at any free port if that is 0; the other
    parameters are those of `replay`. Raises SlipmodeError if `path` cannot be read or has no such
    part, or the viewer cannot be started.
    """
    with tempfile.TemporaryDirectory() as folder:
        rrd = Path(folder) / "recording.rrd"
        replay(path, save=rrd, selection=selection, playing=playing)
        with browser_viewer(rrd, port) as address:
            yield address


def _convert(data: RecordingData, target: Path | Viewer, playing: Playing | None) -> None:
    from slipmode.runner.view.rerun_sink import RerunSink  # it takes a while to import

    shown = as_curves(data.channels) if data.external else data.channels
    channels = [channel for channel, _, _ in shown.values()]
    with RerunSink(target, data.header, channels, playing) as sink:
        for topic, (_, time, values) in shown.items():
            sink.write(topic, time, values)
        for event in data.events:
            sink.event(event.time, event.level, event.message)
