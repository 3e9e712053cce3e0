"""The FMU's shared library for other platforms, compiled by zig (package `ziglang`)."""

from __future__ import annotations

import hashlib
import importlib.util
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from slipmode.fmu.archive import binaries
from slipmode.rom import SlipmodeError
from slipmode.rom.table.cache import cache_folder

# The oldest systems that the libraries load on: glibc 2.17, macOS 11.
TARGETS = {
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-darwin": "x86_64-macos.11.0",
    "aarch64-darwin": "aarch64-macos.11.0",
}
# As CMakeLists.txt compiles the host's; without optimisation zig would link a sanitizer runtime.
_FLAGS = (
    *("-shared", "-O2", "-s", "-std=c99", "-fvisibility=hidden", "-DSM_HIDDEN"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"),
)


def platform_binary(platform_tuple: str) -> bytes:
    """The shared library of a platform, from the cache if it was compiled before.

    Raises
    ------
    SlipmodeError
        If the platform is unknown, zig is not installed, or it fails.
    """
    if platform_tuple not in TARGETS:
        raise SlipmodeError(f"platforms: {platform_tuple} is none of {', '.join(TARGETS)}")
    if importlib.util.find_spec("ziglang") is None:
        raise SlipmodeError(
            "platforms: compiling for other platforms needs zig: pip install 'slipmode[platforms]'"
        )
    sources = binaries.source_files()
    flags = ("-target", TARGETS[platform_tuple], *_FLAGS)
    suffix = binaries.extension(platform_tuple)
    kept = cache_folder() / f"{_key(sources, flags)}{suffix}"
    if kept.is_file():
        return kept.read_bytes()
    library = _compile(sources, flags, suffix)
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_bytes(library)
    except OSError:
        return library  # it will be compiled again next time
    return library


def fmi_headers() -> Path:
    """Where the fmpy package keeps the headers of the standard."""
    found = importlib.util.find_spec("fmpy")
    if found is None or not found.submodule_search_locations:
        raise SlipmodeError("fmpy: not installed; install slipmode again")
    return Path(found.submodule_search_locations[0]) / "c-code"


def _key(sources: Mapping[str, Path], flags: tuple[str, ...]) -> str:
    digest = hashlib.sha256(" ".join((version("ziglang"), version("fmpy"), *flags)).encode())
    for name, path in sources.items():
        digest.update(name.encode() + path.read_bytes())
    return digest.hexdigest()[:32]


def _compile(sources: Mapping[str, Path], flags: tuple[str, ...], suffix: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"library{suffix}"
        command = [
            *(sys.executable, "-m", "ziglang", "cc", *flags),
            *(f"-I{path}" for path in binaries.INCLUDE_FOLDERS),
            *("-isystem", str(fmi_headers())),
            *(str(path) for path in sources.values() if path.suffix == ".c"),
            *("-lm", "-o", str(target)),
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise SlipmodeError(f"platforms: zig cannot compile the FMU's sources: {last}")
        return target.read_bytes()
