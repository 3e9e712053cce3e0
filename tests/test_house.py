"""The house: rooms by concept, none crowded, whose imports flow one way."""

import ast
import importlib
import re
import subprocess
from collections import Counter
from itertools import zip_longest
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("rom", "fmu", "runner", "benchmarks")
# Rooms from the ground up: each knows those before it, none after.
FLOORS = {
    "rom": "kernel structure laws reduction contact full validity table slow identification",
    "runner": "recording scene plan transients view",
}
SATELLITES = {("rom", "identification"), ("rom", "cyclic"), ("runner", "explore")}
MOST_FILES, MOST_LINES = 12, 500
# What keeps tests valid when the inside is rewritten.
INTERNAL = re.compile(r"slipmode\.\w+\.")  # below the public packages
LEAST_SHARE_OF_ORACLES, MOST_INTERNAL_TEST_FILES, MOST_TEST_LINES = 0.4, 30, 26_000


def sources(*endings):
    """Source files that git knows."""
    if not (ROOT / ".git").exists():
        pytest.skip("needs the checkout")
    command = ["git", "ls-files", "--", *(f"*{ending}" for ending in endings)]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return [Path(line) for line in listed.stdout.splitlines() if (ROOT / line).exists()]


def imported(path):
    """Modules of the packages, as ("rom", "table", "model"), that a file imports anywhere."""
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            parts = [part for part in node.module.split(".") if part != "slipmode"]
            yield from ((*parts, name.name) for name in node.names)


@pytest.mark.parametrize("ending", [".py", ".c"])
def test_no_folder_is_crowded_and_no_file_long(ending):
    files = sources(ending, ".h") if ending == ".c" else sources(ending)
    assert len(files) > 100
    crowded = {f: n for f, n in Counter(path.parent for path in files).items() if n > MOST_FILES}
    assert not crowded
    long = {path: len((ROOT / path).read_text().splitlines()) for path in files}
    assert not {path: n for path, n in long.items() if n > MOST_LINES}


def test_packages_know_only_those_below():
    for path in sources(".py"):
        if path.parts[0] in PACKAGES:
            above = PACKAGES[PACKAGES.index(path.parts[0]) + 1 :]
            assert not {names[0] for names in imported(path)} & set(above), path


@pytest.mark.parametrize("package", FLOORS)
def test_rooms_know_only_those_below(package):
    floors = FLOORS[package].split()
    seen = set()
    for path in sources(".py"):
        room = path.parts[1].removesuffix(".py") if path.parts[0] == package else None
        if room not in floors:
            continue
        seen.add(room)
        above = set(floors[floors.index(room) + 1 :])
        known = {names[1] for names in imported(path) if names[0] == package and len(names) > 1}
        assert not known & above, path
    assert seen == set(floors)


def test_satellites_meet_others_in_public_names():
    """Names are in the `__all__` of a package, and the core imports no satellite."""
    for path in sources(".py"):
        room = path.parts[:2]
        for *module, name in imported(path):
            owner = tuple(module[:2])
            if owner == room or not {room[0], *owner[:1]} <= set(PACKAGES[:3]):
                continue
            face = importlib.import_module(".".join(("slipmode", *module)))
            if len(owner) == 1:  # slipmode.rom and slipmode.runner have names of satellites too
                owner = tuple(getattr(getattr(face, name), "__module__", "").split(".")[1:3])
            if owner in SATELLITES and owner != room:
                assert (owner[0], room[0]) == ("rom", "runner"), f"{path}: {name} of a satellite"
            if {room, owner} & SATELLITES:
                assert name in getattr(face, "__all__", ()), f"{path}: {name} of {face.__name__}"


def has_oracle(node):
    """Whether the marker `oracle` is among the decorators, or in `pytestmark` of a module."""
    if isinstance(node, ast.Module):
        marks = [n for n in node.body if isinstance(n, ast.Assign)]
        marks = [n for n in marks if ast.unparse(n.targets[0]) == "pytestmark"]
    else:
        marks = node.decorator_list
    return any("mark.oracle" in ast.unparse(mark) for mark in marks)


def test_tests_are_evidence_through_public_names():
    tests = [path for path in sources(".py") if path.parts[0] == "tests"]
    functions = oracles = 0
    internal = set()
    for path in tests:
        module = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        for node in ast.walk(module):
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                functions += 1
                oracles += has_oracle(node) or has_oracle(module)
            if isinstance(node, ast.ImportFrom) and INTERNAL.match(node.module or ""):
                internal.add(path)
    assert oracles / functions >= LEAST_SHARE_OF_ORACLES, (oracles, functions)
    assert len(internal) <= MOST_INTERNAL_TEST_FILES, internal
    of_tests = [path for path in sources(".py", ".c", ".h") if path.parts[0] == "tests"]
    lines = sum(len((ROOT / path).read_text(encoding="utf-8").splitlines()) for path in of_tests)
    assert lines <= MOST_TEST_LINES


WALK = re.compile(r"^\| `(?P<name>[\w.]+)` \| `(?P<path>[\w./]+)` \| `?(?P<call>[^`]+)", re.M)


def body(path, name):
    """Text of a function, of Python ("Class.method" too) or C."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if path.endswith(".py"):
        node = ast.parse(text)
        for part in name.split("."):
            node = [n for n in node.body if getattr(n, "name", None) == part][-1]
        return ast.get_source_segment(text, node).partition("\n")[2]
    return re.search(rf"^\w[^;{{}}]*\b{name}\([^;{{}}]*\{{\n.*?^}}", text, re.M | re.S)[0]


def test_walks_lead_from_call_to_call():
    """The tables of CONTRIBUTING.md that follow a quantity through the code."""
    blocks = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("\n\n")
    walks = [list(WALK.finditer(block)) for block in blocks]
    assert sum(map(len, walks)) > 25
    for row, following in (pair for rows in walks for pair in zip_longest(rows, rows[1:])):
        text = body(row["path"], row["name"])
        assert following is None or row["call"].rstrip() in text, row["name"]
