"""What is imported when, and what is said where a package is missing that only some need."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from slipmode.runner import run

ROOT = Path(__file__).parents[1]
DAMPER = ROOT / "examples/damper_preload.toml"
HEAVY = {"rerun", "fmpy", "mcap", "matplotlib", "pyarrow", "PIL", "google.protobuf"}
HEAVY |= {"scipy.io", "scipy.sparse.linalg", "scipy.stats"}
HEAVY |= {"dask", "distributed", "xarray", "zarr", "SALib", "pandas"}
EXTRAS = ("fmpy", "matplotlib", "sksundae", "threadpoolctl", "ziglang")
EXTRAS += ("dask", "distributed", "xarray", "zarr", "SALib")
BAR = re.compile(r"\[\d+:\d\d")  # of progress, where the machine is slow


def python(code, *arguments):
    command = [sys.executable, "-P", "-c", code, *map(str, arguments)]  # of all, only slipmode
    return subprocess.run(command, capture_output=True, text=True)


def loaded_by(statement, among=HEAVY):
    done = python(f"import sys\n{statement}\nprint(*sys.modules)")
    assert done.returncode == 0, done.stderr
    return among & set(done.stdout.splitlines()[-1].split())


def slipmode_without(packages, *commands):
    """What commands return where these packages are not installed, and the lines they say."""
    blocked = "".join(f"sys.modules[{name!r}] = None\n" for name in packages)
    words = [[str(word) for word in command] for command in commands]
    code = f"from slipmode.__main__ import main\nreturned = [main(each) for each in {words!r}]"
    done = python(f"import sys\n{blocked}{code}\nprint(returned)")
    lines = [line for line in done.stderr.splitlines() if line and not BAR.search(line)]
    return json.loads(done.stdout.splitlines()[-1]), lines


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return run("one-mode", tmp_path_factory.mktemp("logs")).mcap


@pytest.mark.parametrize(
    "statement",
    [
        "from slipmode.rom import reduce, tabulate, steady, response_curve",
        "from slipmode.fmu import Component",
        "from slipmode.__main__ import main; main(['plan', 'one-mode'])",
    ],
)
def test_models_components_and_plans_load_nothing_for_files_or_pictures(statement):
    assert loaded_by(statement) == set()


def test_packages_and_help_load_no_numbers():
    code = "from slipmode import rom, fmu, runner\nfrom slipmode.runner.cli import main"
    code += "\ntry: main(['--help'])\nexcept SystemExit: pass"
    assert loaded_by(code, {"numpy", "scipy"}) == set()


def test_no_extra_is_needed_to_run_export_and_look(tmp_path):
    recording = tmp_path / "one-mode.mcap"
    commands = (
        ("run", "one-mode", "-o", tmp_path),
        ("info", recording),
        ("replay", recording, "--save", tmp_path / "again.rrd"),
        ("export", recording, "-o", tmp_path / "one-mode.npz"),
        ("fmu", "one-mode", "-o", tmp_path / "one-mode.fmu"),
    )
    assert slipmode_without(EXTRAS, *commands) == ([0] * len(commands), [])


@pytest.mark.parametrize(
    "commands",
    [
        {
            ("run", "one-mode", "--fmu", "one-mode.fmu", "-o", "OUT"): ("fmpy", "fmu"),
            ("curve", "one-mode", "-o", "OUT"): ("matplotlib", "pictures"),
        },
        {
            ("export", "RECORDING", "-o", "one-mode.csv"): ("pyarrow", "export"),
            ("fmu", "one-mode", "--platforms", "x86_64-windows"): ("ziglang", "platforms"),
            ("explore", "one-mode", "-o", "OUT"): ("ziglang", "explore"),
        },
        pytest.param({("study", DAMPER, "-o", "OUT"): ("zarr", "study")}, marks=pytest.mark.slow),
        pytest.param(
            {("study", DAMPER, "-o", "OUT", "--scheduler", "tcp://a:1"): ("distributed", "dask")},
            marks=pytest.mark.slow,
        ),
    ],
    ids=["runs", "exports", "studies", "clusters"],
)
def test_a_missing_package_is_one_line_that_names_its_extra(recording, tmp_path, commands):
    places = {"RECORDING": recording, "OUT": tmp_path / "out"}
    words = [[places.get(word, word) for word in command] for command in commands]
    said = "slipmode: {} is not installed: pip install 'slipmode[{}]'"
    expected = [1] * len(words), [said.format(*each) for each in commands.values()]
    assert slipmode_without({package for package, _ in commands.values()}, *words) == expected
