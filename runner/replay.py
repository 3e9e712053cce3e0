"""Showing a recording in Rerun."""

from __future__ import annotations

import os
import socket
import tempfile
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rerun.experimental import ViewerClient

from rom.errors import SlipmodeError
from runner.load import RecordingData, read
from runner.planes import TIMELINE
from runner.rerun_sink import RerunSink
from runner.views import VIEWER

_VIEWER_PACKAGES = (
    "mesa-vulkan-drivers libvulkan1 libgl1-mesa-dri libegl1 libxkbcommon0 fonts-dejavu-core"
)
_SETTLING_TIME = 20.0  # [s] at most, until the picture stands still


def replay(
    path: str | Path, save: str | Path | None = None, screenshot: str | Path | None = None
) -> None:
    """Show an MCAP recording in Rerun, as the run itself would have shown it.

    Parameters
    ----------
    path : path
        An MCAP file written by slipmode.
    save : path, optional
        Write an .rrd file, views included, instead of opening the viewer.
    screenshot : path, optional
        Write a PNG of all views at the end of the recording, without a window.

    Raises
    ------
    SlipmodeError
        If `path` cannot be read, or no viewer can be started for the screenshot.
    OSError
        If `save` or `screenshot` cannot be written.
    """
    data = read(path)
    if save is not None or screenshot is None:
        _convert(data, save)
    if screenshot is not None:
        with tempfile.TemporaryDirectory() as folder:
            rrd = Path(folder) / "recording.rrd"
            _convert(data, rrd)
            picture = _photograph(rrd, data.end_time)
        Path(screenshot).write_bytes(picture)


def _convert(data: RecordingData, path: str | Path | None) -> None:
    """Write a recording to an .rrd file, or to a new viewer where there is no path."""
    channels = [channel for channel, _, _ in data.channels.values()]
    with RerunSink(path, data.header, channels) as sink:
        for topic, (_, time, values) in data.channels.items():
            sink.write(topic, time, values)
        for event in data.events:
            sink.event(event.time, event.level, event.message)


def _photograph(rrd: Path, time: float) -> bytes:
    """PNG of a recording at simulation time `time`, by a viewer without a window."""
    try:
        with _quiet_viewer() as viewer:
            viewer.open(str(rrd))
            viewer.set_time(TIMELINE, duration=time, play_state="paused")
            return _settled(viewer)
    except (RuntimeError, ConnectionError) as error:
        raise SlipmodeError(
            "no viewer could be started for the screenshot: it needs a graphics driver, "
            f"on Debian: apt-get install {_VIEWER_PACKAGES}"
        ) from error


def _settled(viewer: ViewerClient) -> bytes:
    """Picture that two shots in a row agree on: views take a few frames to fill."""
    deadline = clock.monotonic() + _SETTLING_TIME
    picture = viewer.take_screenshot()
    while clock.monotonic() < deadline:
        clock.sleep(0.3)
        previous, picture = picture, viewer.take_screenshot()
        if picture == previous:
            break
    return picture


@contextmanager
def _quiet_viewer() -> Iterator[ViewerClient]:
    """A viewer without a window, which ends with the context and logs errors only."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    log_filter = os.environ.get("RUST_LOG")
    os.environ["RUST_LOG"] = "off"
    try:
        viewer = ViewerClient.spawn(headless=True, port=port, executable_path=VIEWER)
    finally:
        if log_filter is None:
            del os.environ["RUST_LOG"]
        else:
            os.environ["RUST_LOG"] = log_filter
    with viewer:
        yield viewer
