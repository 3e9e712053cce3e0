"""Python reads the same structures and functions from slipmode.h as the compiler."""

import ctypes
import shutil

import numpy as np
import pytest
from native import CORE, run

from slipmode.rom import kernel
from slipmode.rom.kernel.structures import HEADERS, STRUCTURES


@pytest.mark.oracle
def test_fields_are_where_the_compiler_puts_them(tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    assert len(STRUCTURES) == sum(path.read_text().count("typedef struct {") for path in HEADERS)
    expected, printed = [], []
    for name, structure in STRUCTURES.items():
        for field, *_ in structure._fields_:
            place = getattr(structure, field)
            expected.append(f"{ctypes.sizeof(structure)} {place.offset} {place.size}")
            sizes = f"sizeof({name}), offsetof({name}, {field}), sizeof((({name} *)0)->{field})"
            printed.append(f'printf("%zu %zu %zu\\n", {sizes});')
    source, program = tmp_path / "layout.c", tmp_path / "layout"
    head = '#include <stdio.h>\n#include "slipmode.h"\nint main(void) {\n'
    source.write_text(head + "\n".join(printed) + "\nreturn 0;\n}\n")
    assert run(compiler, "-I", CORE, source, "-o", program).returncode == 0
    assert run(program).stdout.splitlines() == expected


@pytest.mark.parametrize(
    "array",
    [np.zeros(4, dtype=np.float32), np.zeros(8)[::2], np.zeros((3, 2)).T, np.zeros(4, int)],
)
def test_arrays_of_another_type_or_layout_are_refused(array):
    with pytest.raises(TypeError, match=r"^node_a: must be a C-contiguous array of double, got"):
        kernel.Table(node_a=array)
    with pytest.raises(ctypes.ArgumentError, match="amplitudes: must be a C-contiguous"):
        kernel.lib.sm_table_lookup(kernel.Table(), 1, array, np.zeros(1, dtype=complex))


def test_unknown_fields_other_structures_and_integers_that_do_not_fit_are_refused():
    with pytest.raises(AttributeError):
        kernel.Table(nodes=1)
    with pytest.raises(TypeError, match="response: must be sm_modal_response, got sm_table"):
        kernel.Contact(response=kernel.Table())
    with pytest.raises(OverflowError, match="steps = 4294967360: does not fit"):
        kernel.Discretisation(steps=2**32 + 64)
