"""The FMU's shared library: the host's, which is part of the package, and its C sources."""

from __future__ import annotations

import importlib.util
import platform
import sys
from pathlib import Path

from slipmode.rom import SlipmodeError

_PACKAGE = Path(__file__).parents[1]
_KERNEL = _PACKAGE.parent / "rom" / "kernel"

# What the FMU does not need of the core, here and in CMakeLists.txt: it makes no friction tables
# and computes nothing in full order.
_LEFT_OUT = {
    *("torus", "torus_check", "torus_group", "torus_march", "torus_growth", "smooth_stage"),
    *("periodicity", "acceleration", "harmonics", "full"),
}

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


def source_files() -> dict[str, Path]:
    """C sources and headers by name; the standard's own headers are not among them."""
    own = sorted((_PACKAGE / "src").glob("*.[ch]"))
    core = [path for path in sorted(_KERNEL.glob("*.[ch]")) if path.stem not in _LEFT_OUT]
    if not own or not core:
        raise SlipmodeError("fmu/src: the FMU's sources are missing; install slipmode again")
    return {path.name: path for path in (*own, *core)}
