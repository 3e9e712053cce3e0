"""The FMU's shared library: the host's, which is part of the package, and its C sources."""

from __future__ import annotations

import importlib.util
import platform
import sys
from pathlib import Path

from slipmode.fmu.description.options import FmiVersion
from slipmode.rom import SlipmodeError

# Headers and sources of the FMU and of the core; in an FMU one folder, sources/.
INCLUDE_FOLDERS = (Path(__file__).parents[1] / "src", Path(__file__).parents[2] / "rom" / "kernel")


def host_platform() -> str:
    """Return the platform tuple of this machine, as FMI 3.0 names it."""
    machine = platform.machine().lower()
    architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    return f"{architecture}-{system}"


def host_binary() -> bytes:
    """Return the shared library that was built with the package."""
    found = importlib.util.find_spec("slipmode.fmu._native")
    if found is None or found.origin is None:
        raise SlipmodeError(
            "slipmode.fmu._native: the FMU's library is missing; install slipmode again"
        )
    return Path(found.origin).read_bytes()


def folder(platform_tuple: str, fmi: int) -> str:
    """Return the folder of a platform's library inside binaries/.

    FMI 2.0 has its own names for the platforms that it knew.
    """
    machine, system = platform_tuple.split("-")
    short = {"linux": "linux64", "windows": "win64", "darwin": "darwin64"}
    return short[system] if fmi == 2 and machine == "x86_64" else platform_tuple


def extension(platform_tuple: str) -> str:
    """Return the suffix of a shared library there."""
    system = platform_tuple.rpartition("-")[2]
    return {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}[system]


def library_path(platform_tuple: str, fmi: int, identifier: str) -> str:
    """Return the path of a platform's library inside an FMU."""
    name = f"{identifier}{extension(platform_tuple)}"
    return f"binaries/{folder(platform_tuple, fmi)}/{name}"


def source_files(fmi: FmiVersion | None = None) -> dict[str, Path]:
    """Return C sources and headers by their place in sources/, without the standard's headers.

    No two have the same file name, for importers that put all objects into one folder. With `fmi`
    the files of the other version of the standard are left out. Files of the core that make
    friction tables or compute in full order are never included.
    """
    found = {
        path.relative_to(folder).as_posix(): path
        for folder in INCLUDE_FOLDERS
        for path in sorted(folder.rglob("*.[ch]"))
    }
    if not {"slipmode.h", "faces/fmi2.c"} <= found.keys():
        raise SlipmodeError("fmu/src: the FMU's sources are missing; install slipmode again")
    other = {None: (), 2: ("faces/fmi3",), 3: ("faces/fmi2",)}[fmi]
    left_out = ("torus/", "full/", *other)
    return {name: path for name, path in found.items() if not name.startswith(left_out)}
