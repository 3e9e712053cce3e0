"""C sources compiled by zig, for whatever machine; results are kept in the cache."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path

from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.storage.files import replacing
from slipmode.rom.table import disk_cache

# Headers and sources of the FMU and of the core; in an FMU one folder, sources/.
INCLUDE_FOLDERS = (Path(__file__).parents[1] / "src", Path(__file__).parents[2] / "rom" / "kernel")

# Options of CMakeLists.txt, without warnings and options of GCC only. Without optimisation zig
# would link a sanitizer runtime.
OPTIONS = (
    *("-O3", "-fvisibility=hidden", "-fopenmp-simd"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"),
)
FACE_OPTIONS = ("-ffp-contract=off",)  # for sources in fmu/src, after OPTIONS
DEFINITIONS = ("SM_HIDDEN", "SM_OPENMP_SIMD")


@dataclass(frozen=True)
class Target:
    """A machine, and what its compiler and linker need besides the common options."""

    name: str  # as zig names it
    extra_name: str  # the extra of slipmode that it needs
    compiling: tuple[str, ...] = ()
    linking: tuple[str, ...] = ()
    headers: Path | None = None  # folder of the headers of a standard
    packages: tuple[str, ...] = ("ziglang",)  # what the result depends on


def compiled(sources: Mapping[str, Path], target: Target) -> bytes:
    """Return the library that is linked from C sources, from the cache if it was compiled before.

    Raises SlipmodeError if zig is not installed, or it fails.
    """
    extra("ziglang", target.extra_name)
    name = f"{_key(sources, target)}.library"
    found = disk_cache.find(name, _load)
    if found is not None:
        return found
    library = _compile(sources, target)
    disk_cache.keep(name, partial(_save, library))
    return library


def _options(target: Target) -> tuple[str, ...]:
    return ("-std=c99", *OPTIONS, *(f"-D{name}" for name in DEFINITIONS), *target.compiling)


def _key(sources: Mapping[str, Path], target: Target) -> str:
    packages = (version(name) for name in target.packages)
    flags = (target.name, *_options(target), "", *FACE_OPTIONS, "", *target.linking)
    digest = hashlib.sha256(" ".join((*packages, *flags)).encode())
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


def _compile(sources: Mapping[str, Path], target: Target) -> bytes:
    include = [f"-I{folder}" for folder in INCLUDE_FOLDERS]
    if target.headers:
        include += ["-isystem", str(target.headers)]
    with tempfile.TemporaryDirectory() as folder:

        def compile_one(source: Path) -> str:
            face = source.is_relative_to(INCLUDE_FOLDERS[0])
            own = FACE_OPTIONS if face else ()
            made = f"{source.parent.name}-{source.stem}.o"  # several folders have an inputs.c
            _zig(target, folder, "-c", *_options(target), *own, *include, str(source), "-o", made)
            return made

        paths = [path for path in sources.values() if path.suffix == ".c"]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(compile_one, paths))
        _zig(target, folder, "-s", *target.linking, *objects, "-lm", "-o", "library")
        return (Path(folder) / "library").read_bytes()


def _zig(target: Target, folder: str, *arguments: str) -> None:
    """Have zig's C compiler work in a folder."""
    command = (sys.executable, "-m", "ziglang", "cc", "-target", target.name)
    done = subprocess.run(
        (*command, *arguments), cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise SlipmodeError(f"{target.extra_name}: zig cannot compile the FMU's sources: {last}")
