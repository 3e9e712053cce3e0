"""The workflow of CI, and what it calls: read as the service reads it."""

import re
import tomllib
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml", reason="needs slipmode[study]")

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def jobs():
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    return yaml.safe_load(text)["jobs"]


def test_every_step_calls_what_is_there(jobs):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    steps = [step for job in jobs.values() for step in job["steps"]]
    assert all(("run" in step) != ("uses" in step) for step in steps)
    targets = [t for step in steps for t in re.findall(r"make (\S+)", step.get("run", ""))]
    assert {"test", "lint", "docs", "wheels"} <= set(targets)
    for target in targets:
        name = re.escape(target.replace(".venv", "$(VENV)"))
        assert re.search(rf"^(?:.* )?{name}(?: .*)?:(?!=)", makefile, re.MULTILINE), target


def test_every_python_and_system_is_tested(jobs):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    matrix = jobs["test"]["strategy"]["matrix"]
    oldest = project["requires-python"].removeprefix(">=")
    pythons = sorted(matrix["python"], key=lambda version: int(version.split(".")[1]))
    assert pythons[0] == oldest
    minors = [int(version.split(".")[1]) for version in pythons]
    assert minors == list(range(minors[0], minors[-1] + 1))
    assert {"python": oldest, "packages": "oldest"}.items() <= matrix["include"][0].items()
    installed = jobs["installed"]["strategy"]["matrix"]["os"]
    assert {name.split("-")[0] for name in installed} == {"ubuntu", "macos", "windows"}
    assert jobs["installed"]["needs"] in jobs
