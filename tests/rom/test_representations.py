"""What is printed of objects that hold arrays: a line, however large they are."""

import dataclasses
import importlib
import inspect
import pkgutil
import re
from typing import NamedTuple

import numpy as np
import pytest
import scipy.sparse

from slipmode import fmu, rom, runner
from slipmode.rom.short_repr import percentage, short_repr

MOST = 400  # characters of a line
HOLDS_MUCH = re.compile(r"Floats|Complexes|Flags|[Nn][Dd]?[Aa]rray|Signals|list\[|\bbytes\b")
LARGE = re.compile(r"\b(Model|Plan|Reduced|Scene|Table|Harmonics|Structure)\b")
# Compiled, or of use to others nowhere, or with needs that not every installation has.
LEFT_OUT = (
    "slipmode.rom._core",
    "slipmode.fmu._native",
)


def records():
    """Public dataclasses and named tuples of the packages with fields of any size."""
    found = {}
    for package in (rom, fmu, runner):
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if info.name.startswith(LEFT_OUT):
                continue
            for name, kind in vars(importlib.import_module(info.name)).items():
                if inspect.isclass(kind) and kind.__module__ == info.name and name[0] != "_":
                    fields = getattr(kind, "__annotations__", {})
                    record = dataclasses.is_dataclass(kind) or hasattr(kind, "_fields")
                    if record and any(is_large(text) for text in fields.values()):
                        found[f"{info.name}.{name}"] = kind
    return found


def is_large(annotation):
    text = str(annotation)
    return bool(HOLDS_MUCH.search(text) or LARGE.search(text))


def test_what_holds_arrays_is_among_them():
    """That the next test does not pass for want of objects."""
    assert {
        "slipmode.rom.table.model.Model",
        "slipmode.rom.slow.motion.Motion",
    } <= set(records())
    assert {
        "slipmode.runner.run.Recording",
        "slipmode.runner.plan.plan.Plan",
        "slipmode.runner.recording.load.Signals",
    } <= set(records())
    assert len(records()) > 30


@pytest.mark.parametrize("name", records())
def test_no_field_is_printed_whole(name):
    assert not is_generated(records()[name])


def is_generated(kind):
    """Whether dataclass or NamedTuple made the representation, or object did."""
    shown = getattr(kind.__repr__, "__wrapped__", kind.__repr__)
    return shown is not short_repr and inspect.getsourcefile(kind) != shown.__code__.co_filename


@dataclasses.dataclass
class Record:
    small: float
    law: object
    large: object

    __repr__ = short_repr


class Pair(NamedTuple):
    first: int
    large: object

    def __repr__(self):
        return short_repr(self)


@pytest.mark.parametrize(
    ("large", "shown"),
    [
        (np.zeros((5000, 2)), "<float64 5000 x 2>"),
        (np.zeros(0, dtype=complex), "<complex128 0>"),
        ("words " * 900, "'words words words words words '..."),
        (list(range(900)), "<list of 900>"),
        ((1, 2), "(1, 2)"),
        ({"a": np.zeros(9)}, "{'a': <float64 9>}"),
        (Pair(1, 2), "Pair(first=1, large=2)"),
        (Pair(1, "x" * 50), "Pair(...)"),
        (None, "None"),
        (scipy.sparse.eye_array(5), "<float64 5 x 5>"),
    ],
    ids=lambda value: value if isinstance(value, str) and len(value) < 40 else "",
)
def test_what_is_large_is_shown_by_its_size(large, shown):
    assert repr(Pair(1, large)) == f"Pair(first=1, large={shown})"
    assert repr(Record(0.5, rom.Coulomb(2.0), large)) == (
        f"Record(small=0.5, law=Coulomb(limit=2.0), large={shown})"
    )


def check(shown):
    assert "\n" not in shown
    assert 0 < len(shown) < MOST
    return shown


def test_a_model_and_its_parts_are_a_line_each(two_mode_model):
    model = two_mode_model
    for part in (model, model.reduced, model.table, model.harmonics, model.accuracy):
        check(repr(part))
    shown = repr(model)
    assert "2 modes, 2 contacts, consistent, Tanh(limit=2.0, alpha=0.02)" in shown
    assert f"{model.table.node_a.size} x {model.table.node_b.size} nodes to 4, 4" in shown
    assert "harmonics to order" in shown


def test_models_of_many_contacts_and_of_one_mode(one_mode_model):
    law = rom.Tanh(np.linspace(1.0, 2.0, 300), 0.1)
    assert check(repr(law)) == "Tanh(limit=<tuple of 300>, alpha=0.1)"
    check(repr(dataclasses.replace(one_mode_model, law=law)))
    assert "1 mode, 2 contacts" in check(repr(one_mode_model))


def test_a_wave_is_a_line():
    """Its matrices are sparse."""
    wave = rom.travelling_wave(rom.lumped_disk(12, 1e-5), rom.Jenkins(1.0, 5e4), 3)
    assert "12 sectors" in check(str(wave))
    for state in wave.steady_states(0.99 * wave.frequency, {2: 4.0}):
        check(str(state))


def test_a_run_is_a_few_lines(tmp_path):
    recording = runner.run("one-mode", tmp_path)
    data = recording.read()
    for each in (recording.plan, recording.plan.scene, recording.plan.schedule, data):
        check(repr(each))
    check(repr(data.channels["/modes"]))
    shown = str(recording)
    assert len(shown) < MOST + len(str(recording.mcap)) + len(str(recording.rrd))
    assert len(shown.splitlines()) <= 4
    for words in (str(recording.mcap), str(recording.rrd), "/contact/1", "800 s", "complete"):
        assert words in shown
    assert "complete" in repr(data)
    assert "incomplete" in repr(dataclasses.replace(data, damage="cut"))
    assert "800 s" in repr(data)


@pytest.mark.parametrize(
    ("share", "text"),
    [(1.0, "100 %"), (1.234, "120 %"), (0.00129, "0.13 %"), (3e-5, "0.003 %"), (0.0, "0 %")],
)
def test_percentages_have_no_exponents(share, text):
    assert percentage(share) == text
    assert percentage(1e-7) == "below 0.001 %"
