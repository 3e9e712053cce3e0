"""slipmode installed from a wheel, set up from a fresh clone, and packed for others."""

import os
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
RECORDINGS = {"two-mode.mcap", "two-mode.foxglove.json", "two-mode.rrd"}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs the git checkout"),
]


def run(*command, cwd, **environment):
    """Output of a command that must succeed."""
    ours = ("VIRTUAL_ENV", "SLIPMODE_CACHE", "XDG_CACHE_HOME", "MAKEFLAGS", "MAKELEVEL")
    ours += ("PYTHONPYCACHEPREFIX",)
    kept = {k: v for k, v in os.environ.items() if k not in ours}
    done = subprocess.run(command, cwd=cwd, env=kept | environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fresh") / "clone with a space"
    run("git", "clone", "--quiet", str(ROOT), str(folder), cwd=ROOT)
    return folder


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return str(tmp_path_factory.mktemp("home"))


def test_a_wheel_works_outside_the_checkout(clone, home, tmp_path):
    wheels, elsewhere = tmp_path / "wheels", tmp_path / "elsewhere"
    elsewhere.mkdir()
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    run(*pip, "wheel", ".", "--no-deps", "--wheel-dir", str(wheels), cwd=clone, HOME=home)
    (wheel,) = wheels.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    sources = {name for name in names if name.endswith((".c", ".h"))}
    tracked = run("git", "ls-files", "fmu/src/**.[ch]", "rom/kernel/**.[ch]", cwd=clone)
    assert sources == {f"slipmode/{name}" for name in tracked.split()}  # those of an FMU
    assert not [name for name in names if "tests/" in name or "benchmarks/" in name]

    venv.create(tmp_path / "env", with_pip=True)
    bin_folder = tmp_path / "env" / "bin"
    run(str(bin_folder / "pip"), "install", "--quiet", str(wheel), cwd=elsewhere, HOME=home)
    slipmode = str(bin_folder / "slipmode")
    listed = run(slipmode, "scenes", cwd=elsewhere, HOME=home)
    assert "two-mode" in listed
    printed = run(slipmode, "run", "two-mode", cwd=elsewhere, HOME=home)
    assert {path.name for path in elsewhere.glob("logs/*")} == RECORDINGS
    assert "computed" in printed
    printed = run(slipmode, "run", "two-mode", cwd=elsewhere, HOME=home)
    assert "from the cache" in printed
    run(slipmode, "fmu", "two-mode", "-o", "two-mode.fmu", cwd=elsewhere, HOME=home)
    assert "modelDescription.xml" in zipfile.ZipFile(elsewhere / "two-mode.fmu").namelist()


def test_make_run_sets_up_a_fresh_clone_once(clone, home):
    run("make", "run", cwd=clone, HOME=home)
    assert {path.name for path in clone.glob("logs/*.*") if path.suffix} == RECORDINGS
    again = run("make", "--dry-run", "run", cwd=clone, HOME=home)
    assert again.splitlines() == [".venv/bin/slipmode run two-mode --output logs"]
    run("make", "run", cwd=clone, HOME=home)
    changes = run("git", "status", "--porcelain", cwd=clone)
    assert changes == ""


def test_a_source_distribution_builds(clone, home, tmp_path):
    builder = tmp_path / "env"
    venv.create(builder, with_pip=True)
    pip = (str(builder / "bin" / "pip"), "--disable-pip-version-check")
    run(*pip, "install", "--quiet", "build", cwd=tmp_path, HOME=home)
    python = str(builder / "bin" / "python")
    run(python, "-m", "build", "--outdir", str(tmp_path), str(clone), cwd=tmp_path, HOME=home)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    tracked = run("git", "ls-files", "rom", "fmu", "runner", cwd=clone)
    documents = {path.name for pattern in ("*.md", "*.cff") for path in clone.glob(pattern)}
    needed = {"CMakeLists.txt", "pyproject.toml", "LICENSE", *documents, *tracked.split()}
    assert needed <= names
    assert not [name for name in names if name.startswith(("logs/", "build/", ".venv/"))]
    assert list(tmp_path.glob("*.whl"))  # which `build` makes from the archive
