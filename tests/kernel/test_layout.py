"""The structures in Python are those of the compiled kernel."""

import ctypes

import numpy as np
import pytest

from slipmode.rom import kernel
from slipmode.rom.kernel import library, structures


@pytest.fixture(scope="module")
def compiled():
    return library.compiled_layout(kernel.lib)


def swapped(structure):
    """The same with its first two fields of one size in each other's place."""
    if isinstance(structure, np.dtype):
        fields = [(name, structure[name]) for name in structure.names]
        size = [kind.itemsize for _, kind in fields]
    else:
        fields = list(structure._fields_)
        size = [ctypes.sizeof(kind) for _, kind in fields]
    i = next(i for i in range(len(size) - 1) if size[i] == size[i + 1])
    fields[i], fields[i + 1] = fields[i + 1], fields[i]
    if isinstance(structure, np.dtype):
        return np.dtype(fields, align=structure.isalignedstruct)
    return type("Swapped", (ctypes.Structure,), {"_fields_": fields})


def test_every_structure_is_checked(compiled):
    mirrored = {
        value
        for value in vars(structures).values()
        if isinstance(value, np.dtype)
        or (isinstance(value, type) and issubclass(value, ctypes.Structure))
    }
    checked = set(structures.STRUCTURES.values())
    assert mirrored - checked == {ctypes.Structure, structures.Owning, structures.LayoutRow}
    assert compiled.keys() == structures.STRUCTURES.keys()


@pytest.mark.parametrize("name", structures.STRUCTURES)
def test_a_swapped_field_is_named(name, compiled, monkeypatch):
    library.check_layout(compiled)
    monkeypatch.setitem(structures.STRUCTURES, name, swapped(structures.STRUCTURES[name]))
    with pytest.raises(
        ImportError, match=rf"{name}\.\w+ is not laid out .*; install slipmode again"
    ):
        library.check_layout(compiled)


@pytest.mark.parametrize("name", structures.STRUCTURES)
def test_a_field_that_only_one_side_has_is_named(name, compiled):
    fields = dict(compiled[name])
    gone = list(fields)[-1]
    less = {key: value for key, value in fields.items() if key != gone}
    more = fields | {"added": (0, 8)}
    for other, field in ((less, gone), (more, "added")):
        with pytest.raises(ImportError, match=rf"{name}\.{field} is not laid out"):
            library.check_layout({**compiled, name: other})


def test_a_library_without_a_layout_is_refused():
    with pytest.raises(
        ImportError, match="of another version of slipmode; install slipmode again"
    ):
        library.compiled_layout(ctypes.CDLL(None))
