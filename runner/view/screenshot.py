"""Pictures of recordings, by a viewer without a window."""

from __future__ import annotations

import time as clock
from io import BytesIO
from pathlib import Path

from PIL import Image
from rerun.experimental import ViewerClient

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.view.phase_portraits import TIMELINE
from slipmode.runner.view.viewer import windowless_viewer

_PACKAGES = (
    "mesa-vulkan-drivers libvulkan1 libgl1-mesa-dri libegl1 libxkbcommon0 fonts-dejavu-core"
)
_COLORS = 192  # of plots on a plain ground; a third of the bytes of all colours
_NOTICE_TIME = 4.0  # [s] for which a new viewer says across its views where it listens
_SETTLING_TIME = 20.0  # [s] at most, until the picture stands still


def photograph(rrd: Path, time: float) -> bytes:
    """PNG of all views of an .rrd file at simulation time `time` [s].

    Raises
    ------
    SlipmodeError
        If no viewer can be started.
    """
    try:
        with windowless_viewer() as viewer:
            started = clock.monotonic()
            viewer.open(str(rrd))
            viewer.run_command("ui.toggle_top_panel")
            viewer.set_time(TIMELINE, duration=time, play_state="paused")
            return _small(_settled(viewer, started))
    except (RuntimeError, ConnectionError) as error:
        raise SlipmodeError(
            "no viewer could be started for the screenshot: it needs a graphics driver, "
            f"on Debian: apt-get install {_PACKAGES}"
        ) from error


def _settled(viewer: ViewerClient, started: float) -> bytes:
    """Picture that two shots in a row agree on: views take a few frames to fill."""
    previous, picture = b"", viewer.take_screenshot()
    while clock.monotonic() < started + _SETTLING_TIME:
        if picture == previous and clock.monotonic() > started + _NOTICE_TIME:
            break
        clock.sleep(0.3)
        previous, picture = picture, viewer.take_screenshot()
    return picture


def _small(picture: bytes) -> bytes:
    """The same PNG with fewer colours."""
    with Image.open(BytesIO(picture)) as image:
        few = image.convert("RGB").quantize(
            _COLORS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE
        )
    small = BytesIO()
    few.save(small, "PNG", optimize=True)
    return small.getvalue()
