"""The C core under the address and undefined-behaviour sanitizers, by a driver in C."""

import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE = ROOT / "rom" / "kernel"
DRIVER = Path(__file__).parent

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
SANITIZERS = (
    *("-g", "-O1", "-fno-omit-frame-pointer"),
    *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
)
OPENMP_SIMD = ("-fopenmp-simd", "-DSM_OPENMP_SIMD")
FAIL_TO_ALLOCATE = "-Dcalloc=sm_test_calloc"  # lets the driver say when memory runs out

GROUPS = (
    "friction",
    "torus",
    "torus-growth",
    "motion",
    "harmonics",
    "table",
    "slow-flow",
    "directional",
    "component",
    "component-refusals",
    "long-run",
    "random-calls",
)


def run(*command: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


def compiles(compiler: str, folder: Path, *flags: str) -> bool:
    """Whether a program built with the flags runs."""
    source, program = folder / "empty.c", folder / "empty"
    source.write_text("int main(void) { return 0; }\n")
    built = run(compiler, *flags, source, "-o", program)
    return built.returncode == 0 and run(program).returncode == 0


def compile_all(compiler: str, folder: Path, commands: dict[Path, tuple[str, ...]]) -> list[Path]:
    """Compile each source with its flags, side by side."""

    def compile_one(source: Path) -> Path:
        target = folder / f"{'-'.join(source.parts[-4:])}.o"
        result = run(compiler, *commands[source], "-c", source, "-o", target)
        assert result.returncode == 0, result.stderr
        return target

    with ThreadPoolExecutor() as pool:
        return list(pool.map(compile_one, commands))


@pytest.fixture(scope="module")
def compiler() -> str:
    found = shutil.which("cc")
    if found is None:
        pytest.skip("no C compiler (cc)")
    return found


@pytest.fixture(scope="module")
def driver(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kernel")
    if not compiles(compiler, folder, *SANITIZERS):
        pytest.skip(f"{compiler} has no sanitizer runtime")
    simd = OPENMP_SIMD if compiles(compiler, folder, *OPENMP_SIMD) else ()
    flags = (*WARNINGS, *SANITIZERS, *simd, f"-I{CORE}")
    sources = dict.fromkeys(sorted(CORE.rglob("*.c")), (*flags, FAIL_TO_ALLOCATE))
    sources |= dict.fromkeys(sorted(DRIVER.glob("*.c")), flags)
    program = folder / "driver"
    linked = run(
        compiler, *SANITIZERS, *compile_all(compiler, folder, sources), "-lm", "-o", program
    )
    assert linked.returncode == 0, linked.stderr
    return program


def test_every_group_of_checks_is_run_here(driver: Path) -> None:
    assert tuple(run(driver).stdout.split()) == GROUPS


@pytest.mark.parametrize("group", GROUPS)
def test_core(driver: Path, group: str) -> None:
    result = run(driver, group)
    assert result.returncode == 0, result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_core_compiles_without_warnings_when_optimised(name: str, tmp_path: Path) -> None:
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"no {name}")
    flags = (*WARNINGS, "-O3", f"-I{CORE}")
    compile_all(compiler, tmp_path, dict.fromkeys(sorted(CORE.rglob("*.c")), flags))
