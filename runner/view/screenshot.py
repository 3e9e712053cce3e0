"""Pictures of recordings, made by a viewer without a window."""

from __future__ import annotations

import tempfile
import time as clock
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.runner.view.drawing import TIMELINE
from slipmode.runner.view.viewer import windowless_viewer

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

_ATTEMPTS = 3  # each with a viewer of its own
_PATIENCE = 60.0  # [s] until notices are gone, and until the picture stands still


class _NotReadyError(Exception):
    """Why a viewer is too slow for a picture."""


def write_picture(path: str | Path, write_rrd: Callable[[Path], None], time: float) -> None:
    """Write a PNG of the .rrd file that `write_rrd` writes, at simulation time `time` [s]."""
    with tempfile.TemporaryDirectory() as folder:
        rrd = Path(folder) / "recording.rrd"
        write_rrd(rrd)
        picture = photograph(rrd, time)
    with replacing(path) as file:
        file.write(picture)


def photograph(rrd: Path, time: float) -> bytes:
    """Return a PNG of all views of an .rrd file at simulation time `time` [s].

    Raises SlipmodeError if no viewer can be started, or its views do not stand still.
    """
    reason = ""
    for _ in range(_ATTEMPTS):
        try:
            with windowless_viewer() as viewer:
                return _small(_picture(viewer, rrd, time))
        except _NotReadyError as error:
            reason = str(error)
        except (RuntimeError, ConnectionError) as error:
            if "deadline" not in str(error).lower():
                raise SlipmodeError(
                    "no viewer could be started for the screenshot: it needs a graphics driver, "
                    "on Debian: apt-get install mesa-vulkan-drivers libvulkan1 libgl1-mesa-dri "
                    "libegl1 libxkbcommon0 fonts-dejavu-core"
                ) from error
            reason = "it does not answer in time"
    raise SlipmodeError(
        f"no screenshot: the viewer is too slow here ({reason}, {_ATTEMPTS} times); "
        "try again when the machine is less busy, or write an .rrd file with --save"
    )


def _picture(viewer: ViewerClient, rrd: Path, time: float) -> bytes:
    """Return a picture of all views once they are filled and no notice covers them."""
    _wait(viewer, "it keeps a notice over its views", _is_plain)
    viewer.open(str(rrd))
    viewer.run_command("ui.toggle_top_panel")
    viewer.set_time(TIMELINE, duration=time, play_state="paused")
    return _wait(viewer, "its views do not stand still", lambda _: not viewer.get_state().loading)


def _wait(viewer: ViewerClient, complaint: str, fits: Callable[[bytes], bool]) -> bytes:
    """Return a picture that three shots in a row agree on, and that fits.

    One or two may come before a view has begun to fill.
    """
    started, alike = clock.monotonic(), [b""]
    while clock.monotonic() < started + _PATIENCE:
        picture = viewer.take_screenshot()
        alike = [*alike, picture] if picture == alike[-1] else [picture]
        if len(alike) >= 3 and fits(picture):
            return picture
        clock.sleep(0.3)
    raise _NotReadyError(complaint)


def _is_plain(picture: bytes) -> bool:
    """Return whether the corner for notices is empty, as on the first page of a new viewer."""
    with _image().open(BytesIO(picture)) as image:
        width, height = image.size
        box = 0.82 * width, 0.04 * height, 0.99 * width, 0.12 * height
        corner = image.convert("RGB").crop(tuple(map(round, box)))
    return all(least == most for least, most in corner.getextrema())


def _small(picture: bytes) -> bytes:
    """Return a PNG with 192 colours, which has a third of the bytes."""
    Image = _image()
    with Image.open(BytesIO(picture)) as image:
        few = image.convert("RGB").quantize(
            192, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE
        )
    small = BytesIO()
    few.save(small, "PNG", optimize=True)
    return small.getvalue()


def _image() -> Any:
    return extra("PIL.Image", "pictures")
