"""The FMU's C code under the address and undefined-behaviour sanitizers, by a driver in C."""

import shutil
from pathlib import Path

import pytest
from test_kernel import OPENMP_SIMD, SANITIZERS, WARNINGS, compile_all, compiler, compiles, run

from fmu.binaries import source_files
from fmu.cross import fmi_headers

DRIVER = Path(__file__).parent / "fmu"
FEW, MANY = 2_000, 50_000  # sequences of about 25 calls

__all__ = ["compiler"]


@pytest.fixture(scope="module")
def driver(compiler, tmp_path_factory):
    folder = tmp_path_factory.mktemp("native")
    if not compiles(compiler, folder, *SANITIZERS):
        pytest.skip(f"{compiler} has no sanitizer runtime")
    simd = OPENMP_SIMD if compiles(compiler, folder, *OPENMP_SIMD) else ()
    sources = [path for path in source_files().values() if path.suffix == ".c"]
    sources += sorted(DRIVER.glob("*.c"))
    includes = {f"-I{path.parent}" for path in sources} | {f"-isystem{fmi_headers()}"}
    flags = (*WARNINGS, *SANITIZERS, *simd, *sorted(includes))
    program = folder / "sequences"
    objects = compile_all(compiler, folder, dict.fromkeys(sources, flags))
    linked = run(compiler, *SANITIZERS, *objects, "-lm", "-o", program)
    assert linked.returncode == 0, linked.stderr
    return program


def random_sequences(driver, resources, count, seed, *what):
    token = (resources / "token.txt").read_text()
    done = run(driver, f"{resources}/", token, str(count), str(seed), *what)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{count} sequences")


def test_random_sequences_of_calls(driver, unzipped):
    """Legal and illegal: no crash, no leak, the right status, a logged reason, no trace left."""
    random_sequences(driver, unzipped[3] / "resources", FEW, 1)


def test_damaged_resources(driver, unzipped, tmp_path):
    resources = tmp_path / "resources"
    shutil.copytree(unzipped[3] / "resources", resources)
    random_sequences(driver, resources, FEW, 1, "damage")


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_many_random_sequences_of_calls(driver, unzipped, part):
    random_sequences(driver, unzipped[3] / "resources", MANY // 10, 100 + part)
