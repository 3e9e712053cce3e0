"""The C of the FMU: its files call each other in one order, without circles."""

import re
from graphlib import TopologicalSorter
from itertools import pairwise

from slipmode.fmu.archive.binaries import INCLUDE_FOLDERS

DEFINITION = re.compile(r"^[a-z][\w *]*?\b(\w+)\([^;]*?\)\s*\{", re.MULTILINE)


def test_files_call_each_other_without_circles():
    texts = {path.name: path.read_text() for path in INCLUDE_FOLDERS[0].rglob("*.c")}
    owner = {}
    for name, text in texts.items():
        for definition in DEFINITION.finditer(text):
            if not definition[0].startswith("static"):
                owner[definition[1]] = name
    assert owner["fmu_step"] == "step.c" and owner["fmu_say"] == "instance.c"
    called = {
        name: {owner[word] for word in re.findall(r"\w+", text) if word in owner} - {name}
        for name, text in texts.items()
    }
    order = list(TopologicalSorter(called).static_order())
    assert order.index("instance.c") < order.index("evaluate.c") < order.index("step.c")


def test_the_instance_s_header_has_the_order_of_the_calls():
    header = (INCLUDE_FOLDERS[0] / "instance" / "instance.h").read_text()
    sections = re.findall(r"---- (\w+\.c)\b", header)
    folder = INCLUDE_FOLDERS[0] / "instance"
    assert sorted(sections) == sorted(path.name for path in folder.glob("*.c"))
    starts = [header.index(f"---- {name}") for name in sections] + [len(header)]
    declared = [
        set(re.findall(r"\b(fmu_\w+)\(", header[start:end])) for start, end in pairwise(starts)
    ]
    for k, name in enumerate(sections):
        used = set(re.findall(r"\b(fmu_\w+)\(", (folder / name).read_text()))
        later = set().union(*declared[k + 1 :])
        assert not used & later, (name, used & later)
