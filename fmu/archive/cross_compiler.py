"""The FMU's shared library for other platforms, compiled by zig (package `ziglang`)."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.metadata import version
from pathlib import Path

from slipmode.fmu.archive import binaries
from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.rom.table import disk_cache

# The oldest systems that the libraries load on: glibc 2.17, macOS 11.
TARGETS = {
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-darwin": "x86_64-macos.11.0",
    "aarch64-darwin": "aarch64-macos.11.0",
}
# Options of CMakeLists.txt, without warnings and options of GCC only. Without optimisation zig
# would link a sanitizer runtime.
OPTIONS = (
    *("-O3", "-fvisibility=hidden", "-fopenmp-simd"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"),
)
FACE_OPTIONS = ("-ffp-contract=off",)  # for sources in fmu/src, after OPTIONS
DEFINITIONS = ("SM_HIDDEN", "SM_OPENMP_SIMD")


def _common() -> tuple[str, ...]:
    return ("-std=c99", *OPTIONS, *(f"-D{name}" for name in DEFINITIONS))


def platform_binary(platform_tuple: str) -> bytes:
    """Return the shared library of a platform, from the cache if it was compiled before.

    Raises
    ------
    SlipmodeError
        If the platform is unknown, zig is not installed, or it fails.
    """
    if platform_tuple not in TARGETS:
        raise SlipmodeError(f"platforms: {platform_tuple} is none of {', '.join(TARGETS)}")
    extra("ziglang", "platforms")
    sources = binaries.source_files()
    name = f"{_key(sources, platform_tuple)}.library"
    found = disk_cache.find(name, _load)
    if found is not None:
        return found
    library = _compile(sources, platform_tuple)
    disk_cache.keep(name, partial(_save, library))
    return library


def fmi_headers() -> Path:
    """Return the folder of the fmpy package with the headers of the standard."""
    return Path(extra("fmpy", "platforms").__file__).parent / "c-code"


def _key(sources: Mapping[str, Path], platform_tuple: str) -> str:
    flags = (TARGETS[platform_tuple], *_common(), "", *FACE_OPTIONS)
    digest = hashlib.sha256(" ".join((version("ziglang"), version("fmpy"), *flags)).encode())
    for name, path in sources.items():
        digest.update(name.encode() + path.read_bytes())
    return digest.hexdigest()[:32]


def _save(library: bytes, path: Path) -> None:
    with replacing(path) as file:
        file.write(hashlib.sha256(library).digest() + library)


def _load(path: Path) -> bytes:
    content = path.read_bytes()
    digest, library = content[:32], content[32:]  # SHA-256 in front of the library
    if hashlib.sha256(library).digest() != digest:
        raise SlipmodeError(f"{path}: damaged: its content does not fit its hash")
    return library


def _compile(sources: Mapping[str, Path], platform_tuple: str) -> bytes:
    library = f"library{binaries.extension(platform_tuple)}"
    independent = () if platform_tuple.endswith("windows") else ("-fPIC",)  # there all code is
    include = [f"-I{folder}" for folder in binaries.INCLUDE_FOLDERS]
    include += ["-isystem", str(fmi_headers())]
    with tempfile.TemporaryDirectory() as folder:

        def compile_one(source: Path) -> str:
            face = source.is_relative_to(binaries.INCLUDE_FOLDERS[0])
            own = FACE_OPTIONS if face else ()
            target = f"{source.stem}.o"
            flags = (*independent, *_common(), *own, *include)
            _zig(platform_tuple, folder, "-c", *flags, str(source), "-o", target)
            return target

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(
                pool.map(compile_one, (p for p in sources.values() if p.suffix == ".c"))
            )
        _zig(platform_tuple, folder, "-shared", "-s", *objects, "-lm", "-o", library)
        return (Path(folder) / library).read_bytes()


def _zig(platform_tuple: str, folder: str, *arguments: str) -> None:
    """Have zig's C compiler work in a folder."""
    command = (sys.executable, "-m", "ziglang", "cc", "-target", TARGETS[platform_tuple])
    done = subprocess.run(
        (*command, *arguments), cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise SlipmodeError(f"platforms: zig cannot compile the FMU's sources: {last}")
