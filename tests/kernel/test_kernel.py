"""The C core under the address and undefined-behaviour sanitizers, in calls from Python."""

import os
import shutil
import sys

import pytest
from native import CORE, TESTS, WARNINGS, compile_all, run

from slipmode.rom.kernel.structures import DECLARATIONS

PUBLIC = ("tanh", "Coulomb", "Jenkins", "lift-off", "tone")
# Functions that only the C of an FMU calls: tests/fmu/native makes random calls of these.
OF_AN_FMU = {
    *("sm_component_advance", "sm_component_motion", "sm_component_recent_motion"),
    *("sm_component_check", "sm_component_checked_create", "sm_contact_check"),
    *("sm_slow_flow_directional", "sm_slow_flow_rate", "sm_table_check", "sm_tone_present"),
    "sm_component_set_amplitude",
}
CHECKED_AS_A_BRANCH = {"sm_curve_point_near", "sm_curve_solved"}  # by the same lines of curve.c


def spoiled(sanitized, name, seed, times):
    """Functions of the core that withstood spoiled calls."""
    program, memory = TESTS / "support" / "core" / "spoiled_calls.py", "libasan.so"
    runtime = run("cc", f"-print-file-name={memory}").stdout.strip()
    options = {"LD_PRELOAD": runtime, "ASAN_OPTIONS": "detect_leaks=0"}  # Python keeps memory
    options["PYTHONPATH"] = str(TESTS / "support")
    given = (sys.executable, program, sanitized["core"], name, str(seed), str(times))
    done = run(*given, env=os.environ | options)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def test_spoiled_calls_are_refused_or_have_finite_results(sanitized):
    """Nor do they change a state, keep memory, or read beyond an array."""
    assert "sm_tone_step" in spoiled(sanitized, "tone", 1, 2)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_every_function_withstands_many_spoiled_calls(sanitized, seed):
    found = set().union(*(spoiled(sanitized, name, seed, 30) for name in PUBLIC))
    declared = {part.split("(")[0] for part in DECLARATIONS.split("SM_API sm_status ")[1:]}
    assert declared - OF_AN_FMU - CHECKED_AS_A_BRANCH <= found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_core_compiles_without_warnings_when_optimised(name, tmp_path):
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"no {name}")
    flags = (*WARNINGS, "-O3", f"-I{CORE}")
    compile_all(compiler, tmp_path, dict.fromkeys(sorted(CORE.rglob("*.c")), flags))
