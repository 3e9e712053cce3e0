"""The C sources of an FMU and its libraries: the host's, and others that zig compiles."""

from __future__ import annotations

import importlib.util
import platform
import sys
from pathlib import Path

from slipmode.fmu.archive.zig import INCLUDE_FOLDERS, Target, compiled
from slipmode.fmu.description.options import FmiVersion
from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra


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
    other = {None: (), 2: ("faces/fmi3",), 3: ("faces/fmi2",)}[fmi]
    return sources_without("faces/browser/", *other)


def sources_without(*left_out: str) -> dict[str, Path]:
    """Return C sources and headers by their place in sources/, but for some folders or files.

    Files of the core that make friction tables or compute in full order are never included.
    """
    found = {
        path.relative_to(folder).as_posix(): path
        for folder in INCLUDE_FOLDERS
        for path in sorted(folder.rglob("*.[ch]"))
    }
    if not {"slipmode.h", "faces/fmi2.c"} <= found.keys():
        raise SlipmodeError("fmu/src: the sources of the FMU are missing; install slipmode again")
    without = ("torus/", "full/", *left_out)
    return {name: path for name, path in found.items() if not name.startswith(without)}


# The oldest systems that the libraries load on: glibc 2.17, macOS 11.
TARGETS = {
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-darwin": "x86_64-macos.11.0",
    "aarch64-darwin": "aarch64-macos.11.0",
}


def platform_binary(platform_tuple: str) -> bytes:
    """Return the shared library of a platform, from the cache if it was compiled before.

    Raises SlipmodeError if the platform is unknown, zig is not installed, or it fails.
    """
    if platform_tuple not in TARGETS:
        raise SlipmodeError(f"platforms: {platform_tuple} must be one of {', '.join(TARGETS)}")
    independent = () if platform_tuple.endswith("windows") else ("-fPIC",)  # there all code is
    return compiled(
        source_files(),
        Target(
            TARGETS[platform_tuple],
            "platforms",
            compiling=independent,
            linking=("-shared",),
            headers=fmi_headers(),
            packages=("ziglang", "fmpy"),
        ),
    )


def fmi_headers() -> Path:
    """Return the folder of the fmpy package with the headers of the standard."""
    return Path(extra("fmpy", "platforms").__file__).parent / "c-code"
