"""Python reads the same structures and functions from slipmode.h as the compiler."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from slipmode.rom import kernel
from slipmode.rom.kernel import library, structures
from slipmode.rom.kernel.structures import STRUCTURES


def test_all_of_the_header_is_read():
    assert len(STRUCTURES) == structures.DECLARATIONS.count("typedef struct {")
    assert len(list(library.functions())) == structures.DECLARATIONS.count("\nSM_API ")


def test_fields_are_where_the_compiler_puts_them(tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    expected, printed = [], []
    for name, structure in STRUCTURES.items():
        expected.append(f"{name} {ctypes.sizeof(structure)}")
        printed.append(f'printf("{name} %zu\\n", sizeof({name}));')
        for field, *_ in structure._fields_:
            place = getattr(structure, field)
            expected.append(f"{name}.{field} {place.offset} {place.size}")
            size = f"sizeof((({name} *)0)->{field})"
            printed.append(
                f'printf("{name}.{field} %zu %zu\\n", offsetof({name}, {field}), {size});'
            )
    source, program = tmp_path / "layout.c", tmp_path / "layout"
    body = "\n".join(printed)
    source.write_text(
        f'#include <stdio.h>\n#include "slipmode.h"\nint main(void) {{\n{body}\nreturn 0;\n}}\n'
    )
    folder = structures.HEADERS[0].parent
    subprocess.run([compiler, "-I", folder, source, "-o", program], check=True)
    found = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    assert found.splitlines() == expected


def test_rows_of_arrays_are_structures():
    for rows, name in (("INPUTS", "inputs"), ("ELEMENT", "element"), ("SEGMENT", "segment")):
        assert getattr(kernel, rows).itemsize == ctypes.sizeof(STRUCTURES[f"sm_{name}"])


def test_a_structure_takes_only_its_fields():
    with pytest.raises(AttributeError):
        kernel.Table(nodes=1)


@pytest.mark.parametrize(
    "array",
    [np.zeros(4, dtype=np.float32), np.zeros(8)[::2], np.zeros((3, 2)).T, np.zeros(4, int)],
)
def test_arrays_of_another_type_or_layout_are_refused(array):
    with pytest.raises(TypeError, match=r"^node_a: must be a C-contiguous array of double, got"):
        kernel.Table(node_a=array)
    table = kernel.Table()
    with pytest.raises(TypeError, match=r"^values: "):
        table.values = array
    with pytest.raises(ctypes.ArgumentError, match="amplitudes: must be a C-contiguous"):
        kernel.lib.sm_table_lookup(ctypes.byref(table), 1, array, np.zeros(1, dtype=complex))


def test_integers_that_do_not_fit_are_refused():
    with pytest.raises(OverflowError, match="steps = 4294967360: does not fit"):
        kernel.Discretisation(steps=2**32 + 64)


def test_a_library_of_other_headers_is_refused(monkeypatch, tmp_path):
    message = "from another version of slipmode.h; install slipmode again"
    with pytest.raises(ImportError, match=message):
        library.check_headers(ctypes.CDLL(None))
    changed = tmp_path / "slipmode.h"
    changed.write_bytes(structures.HEADERS[0].read_bytes() + b"\n")
    monkeypatch.setattr(library, "HEADERS", (changed, structures.HEADERS[1]))
    with pytest.raises(ImportError, match=message):
        library.check_headers(kernel.lib)
