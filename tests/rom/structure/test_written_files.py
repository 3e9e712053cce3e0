"""Drawn matrix files from independent writers: each is read right, or refused by name."""

import math

import numpy as np
import pytest
import scipy.sparse
from written.matrices import WRITERS, Drawn, abaqus_substructure, calculix, dmig

from slipmode import rom

pytestmark = pytest.mark.quick

FILES = 66  # the seed of each is its number
LABELLED = (dmig, abaqus_substructure, calculix)


def dense(matrix):
    return matrix.toarray() if scipy.sparse.issparse(matrix) else matrix


def assert_same(found, drawn, tolerance):
    np.testing.assert_allclose(dense(found.stiffness), drawn.K, rtol=tolerance, atol=1e-6)
    np.testing.assert_allclose(dense(found.mass), drawn.M, rtol=tolerance, atol=1e-9)
    if found.loss is not None:  # K4 of Nastran
        np.testing.assert_allclose(dense(found.loss), drawn.K, rtol=tolerance, atol=1e-6)


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(FILES))
def test_a_written_file_is_read_right(seed, tmp_path):
    drawn, write = Drawn(seed), WRITERS[seed % len(WRITERS)]
    path, arguments = write(drawn, tmp_path)
    tolerance = arguments.pop("rtol", 1e-12)
    found = rom.load_structure(path, contact=[0], **arguments)
    assert_same(found, drawn, tolerance)
    assert found.beta == 0.0
    assert (found.loss is not None) == (b"K4" in path.read_bytes())
    if write in LABELLED:
        assert [tuple(pair) for pair in found.labels.table.tolist()] == drawn.labels


@pytest.mark.parametrize("seed", range(FILES))
def test_a_damaged_file_is_refused_or_read_the_same(seed, tmp_path):
    """The end is cut off, or a tenth is overwritten."""
    drawn, write = Drawn(seed), WRITERS[seed % len(WRITERS)]
    path, arguments = write(drawn, tmp_path)
    tolerance = arguments.pop("rtol", 1e-12)
    content = path.read_bytes()
    size = len(content)
    if seed % 2:
        content = content[: math.floor(0.6 * size)]
    else:
        content = content[: size // 3] + b"\x07" * (size // 10) + content[size // 3 + size // 10 :]
    path.write_bytes(content)
    try:
        found = rom.load_structure(path, contact=[0], **arguments)
    except rom.SlipmodeError as refused:
        assert "\n" not in str(refused)
        assert path.name in str(refused)
    else:
        assert_same(found, drawn, tolerance)
