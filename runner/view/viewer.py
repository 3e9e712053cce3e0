"""Rerun viewers: with a window, for recordings; without one, for pictures; for browsers."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import signal
import socket
import subprocess
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO
from urllib.parse import quote, urlsplit

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.storage.files import replacing

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

VIEWER = shutil.which("rerun", path=sysconfig.get_path("scripts"))  # also off the PATH

FLUSH_SECONDS = 60.0  # at most, for Rerun to write what it was given

_URL = "rerun+http://127.0.0.1:9876/proxy"  # where viewers listen by default
_MEMORY = "75%"  # of the machine's; beyond it a viewer drops its oldest data

Process = subprocess.Popen[bytes]


@dataclass(frozen=True)
class Viewer:
    """A viewer that recordings can be sent to."""

    url: str


def application(*described: object) -> str:
    """Return the name of an application in which a viewer keeps the layout of a recording.

    Rerun allows few characters in it.
    """
    return f"slipmode {hashlib.sha256(repr(described).encode()).hexdigest()[:16]}"


def find_viewer(url: str | None = None) -> Viewer:
    """Return a viewer to send recordings to; start one if there is none yet.

    `url` is of a viewer that is running, like rerun+http://127.0.0.1:9876/proxy. Raises
    SlipmodeError if none answers there, or none can be started.
    """
    if url is not None and not _answers(url):
        raise SlipmodeError(f"no viewer at {url}: start one there with the command rerun")
    if url is None and not _answers(_URL):
        port = str(urlsplit(_URL).port)
        command = ["--port", port, "--expect-data-soon", "--memory-limit", _MEMORY]
        failed = "the viewer does not start here"
        _start(command, lambda: _answers(_URL) and _shows(_URL), failed)
    return Viewer(url or _URL)


def _answers(url: str) -> bool:
    """Return whether something listens at a viewer's URL."""
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if host is None or port is None or not url.startswith("rerun") or parts.path != "/proxy":
        raise SlipmodeError(f"a viewer's URL must be like {_URL}, got {url}")
    return _listens(host, port)


def _start(arguments: list[str], is_ready: Callable[[], bool], failed: str) -> Process:
    """Start a viewer that outlives this process, and wait until it is ready."""
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(
            [VIEWER or "rerun", *arguments], stdout=log, stderr=log, start_new_session=True
        )
        deadline = time.monotonic() + 30.0  # a busy machine needs some seconds
        while not is_ready():
            if process.poll() is None and time.monotonic() < deadline:
                time.sleep(0.1)
                continue
            is_late = process.poll() is None
            _end(process)
            reason = "it did not answer within 30 s" if is_late else _last_words(log)
            raise SlipmodeError(f"{failed}: {reason}")
        return process


def _shows(url: str) -> bool:
    """Return whether a viewer has its window; it listens already a moment before."""
    from rerun.experimental import ViewerClient

    try:
        ViewerClient.connect(url).get_state()
    except (RuntimeError, ConnectionError):
        return False
    return True


def _last_words(log: BinaryIO) -> str:
    log.seek(0)
    uncolored = re.sub(rb"\x1b\[[0-9;]*m", b"", log.read())
    lines = uncolored.decode(errors="replace").splitlines()
    return lines[-1].rpartition(": ")[2].rstrip(".") if lines else "it says nothing"


@contextmanager
def browser_viewer(rrd: Path, port: int = 0) -> Iterator[str]:
    """Serve an .rrd file to browsers of this machine until the context ends.

    Yields the address of the page, at `port`, or at any free port if that is 0. Raises
    SlipmodeError if the viewer cannot be started.
    """
    page, data = port or _free_port(), _free_port()
    command = ["--serve-web", "--bind", "127.0.0.1", "--port", str(data)]
    command += ["--web-viewer-port", str(page), "--server-memory-limit", _MEMORY, str(rrd)]

    def is_ready() -> bool:
        return all(_listens("127.0.0.1", port) for port in (page, data))

    process = _start(command, is_ready, f"no viewer for browsers at port {page}")
    try:
        source = quote(f"rerun+http://127.0.0.1:{data}/proxy", safe="")
        yield f"http://127.0.0.1:{page}/?url={source}"
    finally:
        _end(process)


def _end(process: Process) -> None:
    """End a process and the processes that it started: the command rerun is a launcher."""
    if os.name == "posix":
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGTERM)
    else:
        process.terminate()
    process.wait()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _listens(host: str, port: int) -> bool:
    try:
        with socket.create_connection((host, port), timeout=3.0):
            return True
    except OSError:
        return False


@contextmanager
def windowless_viewer() -> Iterator[ViewerClient]:
    """Run a viewer without a window until the context ends; it logs nothing.

    Raises RuntimeError or ConnectionError if there is no graphics driver for it.
    """
    from rerun.experimental import ViewerClient

    port = _free_port()
    quiet = {"RUST_LOG": "off"}
    if "XDG_RUNTIME_DIR" not in os.environ:  # of which graphics drivers complain
        quiet["XDG_RUNTIME_DIR"] = tempfile.gettempdir()
    before = os.environ.copy()
    os.environ |= quiet
    try:
        viewer = ViewerClient.spawn(headless=True, port=port, executable_path=VIEWER)
    finally:
        os.environ.clear()
        os.environ |= before
    with viewer:
        yield viewer


class _NotReadyError(Exception):
    """Why a viewer is too slow for a picture."""


def write_picture(path: str | Path, write_rrd: Callable[[Path], None], end: float) -> None:
    """Write a PNG of the .rrd file that `write_rrd` writes, at simulation time `end` [s]."""
    with tempfile.TemporaryDirectory() as folder:
        rrd = Path(folder) / "recording.rrd"
        write_rrd(rrd)
        picture = photograph(rrd, end)
    with replacing(path) as file:
        file.write(picture)


def photograph(rrd: Path, end: float) -> bytes:
    """Return a PNG of all views of an .rrd file at simulation time `end` [s].

    Raises SlipmodeError if no viewer can be started, or its views do not stand still.
    """
    reason = ""
    for _ in range(3):
        try:
            with windowless_viewer() as viewer:
                return _small(_picture(viewer, rrd, end))
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
        f"no screenshot: the viewer is too slow here ({reason}, 3 times); "
        "try again when the machine is less busy, or write an .rrd file with --save"
    )


def _picture(viewer: ViewerClient, rrd: Path, end: float) -> bytes:
    """Return a picture of all views once they are filled and no notice covers them."""
    _wait(viewer, "it keeps a notice over its views", _is_plain)
    viewer.open(str(rrd))
    viewer.run_command("ui.toggle_top_panel")
    viewer.set_time("time", duration=end, play_state="paused")
    return _wait(viewer, "its views do not stand still", lambda _: not viewer.get_state().loading)


def _wait(viewer: ViewerClient, complaint: str, fits: Callable[[bytes], bool]) -> bytes:
    """Return a picture that three shots in a row agree on, and that fits.

    One or two may come before a view starts to fill.
    """
    started, alike = time.monotonic(), [b""]
    while time.monotonic() < started + 60.0:
        picture = viewer.take_screenshot()
        alike = [*alike, picture] if picture == alike[-1] else [picture]
        if len(alike) >= 3 and fits(picture):
            return picture
        time.sleep(0.3)
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
        method, dither = Image.Quantize.MEDIANCUT, Image.Dither.NONE
        few = image.convert("RGB").quantize(192, method=method, dither=dither)
    small = BytesIO()
    few.save(small, "PNG", optimize=True)
    return small.getvalue()


def _image() -> Any:
    return extra("PIL.Image", "pictures")
