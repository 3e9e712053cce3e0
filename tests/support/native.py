"""The C core and the C of an FMU with the sanitizers, as a library and as a program.

Each source is compiled once for both, and again only when it or a header has changed: the
objects are kept in pytest's cache.
"""

import hashlib
import os
import shutil
import subprocess
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from subprocess import CompletedProcess

import pytest

from slipmode.rom.kernel.structures import HEADERS

TESTS = Path(__file__).parents[1]
CORE = TESTS.parent / "rom" / "kernel"
FACE = TESTS.parent / "fmu" / "src"
WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
SANITIZERS = (
    *("-g1", "-O1", "-fno-omit-frame-pointer"),
    *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
)
# What makes the core fast, one body for each number of lanes, would take minutes to instrument.
NOT_INLINED = ("-fno-inline", "-Dalways_inline=unused")
OPENMP_SIMD = ("-fopenmp-simd", "-DSM_OPENMP_SIMD")
# A test says when memory runs out, and counts what is not freed.
ALLOCATE = ("-Dcalloc=sm_test_calloc", "-Dfree=sm_test_free")
ALLOCATION = TESTS / "support" / "core" / "allocation.c"


def run(*command: str | Path, env: Mapping[str, str] | None = None) -> CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False, env=env)


def compile_all(
    compiler: str, folder: Path, commands: dict[Path, tuple[str, ...]]
) -> dict[Path, Path]:
    """{source: object}; those that the folder does not have yet are compiled side by side."""
    folders = (FACE, CORE, *sorted({source.parent for source in commands}))
    headers = sorted({path for folder in folders for path in folder.rglob("*.h")})
    common = run(compiler, "--version").stdout.encode() + b"".join(map(Path.read_bytes, headers))

    def compile_one(source: Path) -> Path:
        flags = " ".join(commands[source])
        content = hashlib.sha256(common + flags.encode() + source.read_bytes()).hexdigest()
        target = folder / f"{source.parent.name}-{source.stem}-{content[:16]}.o"
        if not target.exists():
            made = target.with_suffix(f".{os.getpid()}")
            result = run(compiler, *commands[source], "-c", source, "-o", made)
            assert result.returncode == 0, result.stderr
            made.replace(target)
        return target

    with ThreadPoolExecutor() as pool:
        objects = dict(zip(commands, pool.map(compile_one, commands), strict=True))
    for stale in set(folder.glob("*.o")) - set(objects.values()):
        stale.unlink(missing_ok=True)
    return objects


def _compiles(compiler: str, folder: Path, *flags: str) -> bool:
    """Whether a program built with the flags runs."""
    source, program = folder / "empty.c", folder / "empty"
    source.write_text("int main(void) { return 0; }\n")
    built = run(compiler, *flags, source, "-o", program)
    return built.returncode == 0 and run(program).returncode == 0


@pytest.fixture(scope="session")
def sanitized(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Path]:
    """{"core": shared library, "fmu": program}."""
    compiler, folder = shutil.which("cc"), tmp_path_factory.mktemp("native")
    if compiler is None:
        pytest.skip("no C compiler (cc)")
    if not _compiles(compiler, folder, *SANITIZERS):
        pytest.skip(f"{compiler} has no sanitizer runtime")
    cache = getattr(request.config, "cache", None)
    kept = cache.mkdir("native") if cache else folder
    simd = OPENMP_SIMD if _compiles(compiler, folder, *OPENMP_SIMD) else ()
    flags = (*WARNINGS, *SANITIZERS, *NOT_INLINED, *simd, "-fPIC")

    core = sorted(CORE.rglob("*.c"))
    face = sorted(path for path in FACE.rglob("*.c") if path.parent.name != "browser")
    own = sorted((TESTS / "fmu" / "native").glob("*.c"))
    read = "".join(hashlib.sha256(path.read_bytes()).hexdigest() for path in HEADERS)
    fmi_headers = Path(pytest.importorskip("fmpy").__file__).parent / "c-code"
    through = (*flags, f"-I{FACE}", f"-I{CORE}", f"-isystem{fmi_headers}")
    made_of = (*flags, f"-I{CORE}", *ALLOCATE)
    commands = dict.fromkeys(core, made_of) | {ALLOCATION: flags}
    commands[CORE / "base" / "message.c"] = (*made_of, f'-DSM_HEADERS="{read}"')
    commands |= dict.fromkeys((*face, *own), through)
    objects = compile_all(compiler, kept, commands)

    parts = {"core": (*core, ALLOCATION), "fmu": (*core, *face, *own, ALLOCATION)}
    made = {}
    for name, sources in parts.items():
        made[name] = folder / name
        shared = ("-shared",) if name == "core" else ()
        linked = [objects[source] for source in sources]
        result = run(compiler, *SANITIZERS, *shared, *linked, "-lm", "-pthread", "-o", made[name])
        assert result.returncode == 0, result.stderr
    return made
