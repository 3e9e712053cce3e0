"""The C core through slipmode.h, under the address and undefined-behaviour sanitizers."""

import shutil

import pytest
from native import CORE, WARNINGS, compile_all, run

# Groups of driver/driver.c in its order: closed forms, conservation laws, orders of convergence
PHYSICS = ("friction", "frictional", "elastic", "curves", "long_run")
CONTRACTS = ("same_bits", "refusals", "random_calls")


@pytest.mark.oracle
@pytest.mark.parametrize("group", PHYSICS)
def test_core_agrees_with_closed_forms(drivers, group):
    result = run(drivers["kernel"], group)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("group", CONTRACTS)
def test_core_keeps_its_contracts(drivers, group):
    result = run(drivers["kernel"], group)
    assert result.returncode == 0, result.stderr
    assert tuple(run(drivers["kernel"]).stdout.split()) == PHYSICS + CONTRACTS


@pytest.mark.slow
@pytest.mark.parametrize("group", ["long_run", "random_calls"])
def test_core_for_longer(drivers, group):
    result = run(drivers["kernel"], group, "4")  # times as long
    assert result.returncode == 0, result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_core_compiles_without_warnings_when_optimised(name, tmp_path):
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"no {name}")
    flags = (*WARNINGS, "-O3", f"-I{CORE}")
    compile_all(compiler, tmp_path, dict.fromkeys(sorted(CORE.rglob("*.c")), flags))
