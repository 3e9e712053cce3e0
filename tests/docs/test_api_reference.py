"""The API reference: every public name is on its page, every argument in its docstring."""

import inspect
import re
from pathlib import Path

import pytest

from slipmode import fmu, rom, runner
from slipmode.rom import full

PAGES = Path(__file__).parents[2] / "docs" / "reference"
MODULES = {"rom": rom, "rom-full": full, "fmu": fmu, "runner": runner}
NAMES = [(page, name) for page, module in MODULES.items() for name in module.__all__]
DIRECTIVE = re.compile(r"^\.\. auto(?:class|function|data|exception):: (\S+)$", re.MULTILINE)


def public(case):
    page, name = case
    return getattr(MODULES[page], name)


def described(docstring):
    """Names that the sections Parameters and Attributes of a docstring describe."""
    found = set()
    for section in re.split(r"\n(?=\S[^\n]*\n-{3,}\n)", docstring):
        title, _, body = section.partition("\n")
        if title.strip() in ("Parameters", "Attributes"):
            for entry in re.findall(r"^(\w[\w, ]*?)(?: :|$)", body, re.MULTILINE):
                found |= set(entry.split(", "))
    return found


@pytest.mark.parametrize("page", MODULES)
def test_a_page_has_every_public_name_and_no_other(page):
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    shown = DIRECTIVE.findall(text)
    module = MODULES[page].__name__
    assert len(shown) == len(set(shown))
    names = set(MODULES[page].__all__) - {"__version__", "full"}  # rom.full has its own page
    assert set(shown) == {f"{module}.{name}" for name in names}


@pytest.mark.parametrize("case", NAMES, ids=".".join)
def test_every_argument_and_method_of_a_public_name_is_described(case):
    thing = public(case)
    if inspect.isclass(thing):
        for name, member in vars(thing).items():
            if not name.startswith("_") and (callable(member) or isinstance(member, property)):
                assert inspect.getdoc(member), name
    if not callable(thing) or (inspect.isclass(thing) and getattr(thing, "_is_protocol", False)):
        return
    docstring = inspect.getdoc(thing)
    assert docstring and "Initialize self" not in docstring
    if inspect.isclass(thing) and issubclass(thing, Exception) and "__init__" not in vars(thing):
        return
    words = described(docstring)
    if inspect.isclass(thing):  # fields of a public base class are in its own docstring
        public_names = MODULES[case[0]].__all__
        bases = [base for base in inspect.getmro(thing)[1:] if base.__name__ in public_names]
        words = words.union(*(described(inspect.getdoc(base)) for base in bases))
    arguments = set(inspect.signature(thing).parameters)
    assert arguments - words == set()
