"""Documents beside the code, and docstrings of its rooms: the files and the version they name."""

import ast
import re
from pathlib import Path

import pytest

from slipmode import rom

ROOT = Path(__file__).parents[1]
FILE = re.compile(r"(?<![\w*./-])[\w./-]+\.(?:py|c|h)\b")
ROOMS = [
    path
    for top in ("rom", "fmu", "runner", "benchmarks")
    for path in (ROOT / top).rglob("__init__.py")
]

pytestmark = pytest.mark.quick


def missing(text, *folders):
    """Files named in a text that are in none of the folders."""
    return [name for name in FILE.findall(text) if not any((f / name).is_file() for f in folders)]


def test_the_citation_is_of_this_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (\S+)$", text, re.MULTILINE) == [rom.__version__]


@pytest.mark.parametrize("name", ["CONTRIBUTING.md", "docs/guide/accuracy.md"])
def test_files_that_documents_name_by_path_are_there(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    paths = " ".join(each for each in FILE.findall(text) if each.count("/") > 1)
    assert paths
    assert missing(paths, ROOT) == []


@pytest.mark.parametrize("path", ROOMS, ids=lambda path: path.parent.relative_to(ROOT).as_posix())
def test_files_that_a_room_names_are_there(path):
    words = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    rooms = (each for each in path.parent.rglob("*") if each.is_dir())
    assert missing(words, ROOT, path.parent, *rooms) == []
