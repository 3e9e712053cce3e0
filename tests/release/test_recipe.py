"""The conda recipe says what pyproject.toml says, in names of conda packages."""

import re
import tomllib
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml", reason="needs slipmode[study]")

ROOT = Path(__file__).parents[2]
CONDA_NAMES = {"mcap": "python-mcap"}


def test_version_requirements_and_program_are_those_of_the_package():
    recipe = yaml.safe_load((ROOT / "release" / "conda" / "recipe.yaml").read_text("utf-8"))
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = pyproject["project"]
    assert recipe["context"]["version"] == project["version"]

    def conda(requirement):
        name, bound = re.fullmatch(r"([\w-]+)(>=[\d.]+)", requirement).groups()
        return f"{CONDA_NAMES.get(name, name)} {bound}"

    python = f"python {project['requires-python']}"
    run, host = (recipe["requirements"][kind] for kind in ("run", "host"))
    assert set(run) == {python, *map(conda, project["dependencies"])}
    assert set(host) == {python, "pip", *map(conda, pyproject["build-system"]["requires"])}
    (program,) = recipe["build"]["python"]["entry_points"]
    assert program.split(" = ") == ["slipmode", project["scripts"]["slipmode"]]
    assert recipe["about"]["summary"] == project["description"]
    assert recipe["about"]["license"] == project["license"]
    assert (ROOT / recipe["about"]["license_file"]).is_file()
