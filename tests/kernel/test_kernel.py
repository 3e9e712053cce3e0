"""The C core under the address and undefined-behaviour sanitizers, by a driver in C."""

import shutil
from pathlib import Path

import pytest
from native import CORE, WARNINGS, compile_all, run

GROUPS = (
    "friction",
    "frictional-contact",
    "full",
    "elastic",
    "torus",
    "torus-growth",
    "motion",
    "harmonics",
    "table",
    "curves",
    "slow-flow",
    "directional",
    "disk",
    "component",
    "component-refusals",
    "component-trace",
    "long-run",
    "random-calls",
)


@pytest.fixture
def driver(drivers: dict[str, Path]) -> Path:
    return drivers["kernel"]


def test_every_group_of_checks_is_run_here(driver: Path) -> None:
    assert tuple(run(driver).stdout.split()) == GROUPS


@pytest.mark.parametrize("group", GROUPS)
def test_core(driver: Path, group: str) -> None:
    result = run(driver, group)
    assert result.returncode == 0, result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("group", ["long-run", "random-calls"])
def test_core_for_longer(driver: Path, group: str) -> None:
    result = run(driver, group, "4")  # times as long
    assert result.returncode == 0, result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_core_compiles_without_warnings_when_optimised(name: str, tmp_path: Path) -> None:
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"no {name}")
    flags = (*WARNINGS, "-O3", f"-I{CORE}")
    compile_all(compiler, tmp_path, dict.fromkeys(sorted(CORE.rglob("*.c")), flags))
