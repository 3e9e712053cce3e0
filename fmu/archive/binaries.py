"""The C sources of an FMU and its libraries: the host's, and others that zig compiles."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.metadata import version
from pathlib import Path

from slipmode.fmu.description.options import FmiVersion
from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.rom.table import disk_cache

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
            "slipmode.fmu._native: the library of the FMU is missing; install slipmode again"
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
        raise SlipmodeError("fmu/src: the sources of the FMU are missing; install slipmode again")
    other = {None: (), 2: ("faces/fmi3",), 3: ("faces/fmi2",)}[fmi]
    left_out = ("torus/", "full/", *other)
    return {name: path for name, path in found.items() if not name.startswith(left_out)}


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

    Raises SlipmodeError if the platform is unknown, zig is not installed, or it fails.
    """
    if platform_tuple not in TARGETS:
        raise SlipmodeError(f"platforms: {platform_tuple} must be one of {', '.join(TARGETS)}")
    extra("ziglang", "platforms")
    sources = source_files()
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
    library = f"library{extension(platform_tuple)}"
    independent = () if platform_tuple.endswith("windows") else ("-fPIC",)  # there all code is
    include = [f"-I{folder}" for folder in INCLUDE_FOLDERS]
    include += ["-isystem", str(fmi_headers())]
    with tempfile.TemporaryDirectory() as folder:

        def compile_one(source: Path) -> str:
            face = source.is_relative_to(INCLUDE_FOLDERS[0])
            own = FACE_OPTIONS if face else ()
            target = f"{source.stem}.o"
            flags = (*independent, *_common(), *own, *include)
            _zig(platform_tuple, folder, "-c", *flags, str(source), "-o", target)
            return target

        compiled = [path for path in sources.values() if path.suffix == ".c"]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(compile_one, compiled))
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
        raise SlipmodeError(f"platforms: zig does not compile the sources of the FMU: {last}")
