"""The FMU's shared library: the host's, which is part of the package, and its C sources."""

from __future__ import annotations

import importlib.util
import platform
import sys
from pathlib import Path

from slipmode.fmu.description.description import FmiVersion
from slipmode.rom import SlipmodeError

_PACKAGE = Path(__file__).parents[1]
_FACE = _PACKAGE / "src"
_KERNEL = _PACKAGE.parent / "rom" / "kernel"
INCLUDE_FOLDERS = (_FACE, _KERNEL)  # in an FMU one folder, sources/

# Rooms of the kernel that the FMU has no use for: it makes no friction tables and computes nothing
# in full order.
_ROOMS_LEFT_OUT = ("torus/", "full/")

EXTENSIONS = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}

# FMI 2.0 has names of its own for the platforms that it knew.
_FMI2_NAMES = {
    "x86_64-linux": "linux64",
    "x86_64-windows": "win64",
    "x86_64-darwin": "darwin64",
}


def host_platform() -> str:
    """The platform tuple of this machine, as FMI 3.0 names it."""
    machine = platform.machine().lower()
    architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    return f"{architecture}-{system}"


def host_binary() -> bytes:
    """The shared library that was built with the package."""
    found = importlib.util.find_spec("slipmode.fmu._native")
    if found is None or found.origin is None:
        raise SlipmodeError(
            "slipmode.fmu._native: the FMU's library is missing; install slipmode again"
        )
    return Path(found.origin).read_bytes()


def folder(platform_tuple: str, fmi: int) -> str:
    """Folder of a platform's library inside binaries/."""
    return _FMI2_NAMES.get(platform_tuple, platform_tuple) if fmi == 2 else platform_tuple


def extension(platform_tuple: str) -> str:
    """Suffix of a shared library there."""
    return EXTENSIONS[platform_tuple.rpartition("-")[2]]


def source_files(fmi: FmiVersion | None = None) -> dict[str, Path]:
    """C sources and headers by their place in sources/, without the standard's own headers.

    No two have the same file name, for importers that put all objects into one folder. With
    `fmi`, those that need the headers of that version of the standard alone; else of both.
    """
    found = {
        path.relative_to(folder).as_posix(): path
        for folder in INCLUDE_FOLDERS
        for path in sorted(folder.rglob("*.[ch]"))
    }
    if not {"slipmode.h", "faces/fmi2.c"} <= found.keys():
        raise SlipmodeError("fmu/src: the FMU's sources are missing; install slipmode again")
    other = {None: (), 2: ("faces/fmi3",), 3: ("faces/fmi2",)}[fmi]
    left_out = (*_ROOMS_LEFT_OUT, *other)
    return {name: path for name, path in found.items() if not name.startswith(left_out)}


def is_face(source: Path) -> bool:
    """Whether a source is the FMU's own, not the core's."""
    return source.is_relative_to(_FACE)
