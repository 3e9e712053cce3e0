"""Files .mtx of Abaqus and Matrix Market; matrices of CalculiX."""

from __future__ import annotations

import logging
import re
from io import BytesIO, StringIO
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.text import read_text
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.readers.named import Named, mirrored, symmetric
from slipmode.rom.structure.readers.text import (
    DamagedError,
    has_fortran_exponents,
    numbers,
    with_plain_exponents,
)

_log = logging.getLogger(__name__)

_ELEMENT_MATRIX = re.compile(r"^\*MATRIX\s*,\s*TYPE\s*=\s*([A-Z ]*[A-Z])", re.MULTILINE)
_PARTS = {"STIFFNESS": "stiffness", "MASS": "mass", "VISCOUS DAMPING": "damping"}


def read_matrix_market(path: Path) -> Any:
    """Return the matrix of a Matrix Market file."""
    return _matrix_market(read_text(path))


def abaqus_mass_file(path: Path) -> Path:
    """Return JOB_MASS1.mtx for JOB_STIF2.mtx of the same Abaqus job; the path itself if none."""
    stem, separator, _ = path.stem.rpartition("_STIF")
    found = sorted(path.parent.glob(f"{stem}_MASS*.mtx")) if separator else []
    return found[0] if len(found) == 1 else path


def read_mtx(path: Path) -> Named | dict[str, Any]:
    """Matrix Market, or matrices of Abaqus: of a substructure, or of *MATRIX GENERATE.

    Of *MATRIX OUTPUT any format is read. MATRIX INPUT and LABELS name nodes and directions,
    COORDINATE has rows and columns. DOFs that boundary conditions hold have 1E36 on the diagonal.
    """
    text = read_text(path)
    if text.lstrip().startswith("%%"):
        return Named(mirrored(_matrix_market(text)))
    if _ELEMENT_MATRIX.search(text.upper()):
        return _substructure(text.upper(), path)
    rows = _rows(text, (3, 5), path)
    if rows.shape[1] == 3:
        return Named(symmetric(rows[:, :2], rows[:, 2]))
    ends = rows[:, :4].astype(np.int64).reshape(-1, 2)  # both ends of each entry in turn
    pairs, index = np.unique(ends, axis=0, return_inverse=True)
    matrix = symmetric(index.reshape(-1, 2) + 1, rows[:, 4], len(pairs))
    return Named(matrix, Labels(pairs[:, 0], pairs[:, 1]))


def read_calculix(path: Path) -> Named:
    """.sti or .mas of *FREQUENCY, SOLVER=MATRIXSTORAGE; labels from the job's .dof file."""
    rows = _rows(read_text(path), (3,), path)
    matrix = symmetric(rows[:, :2], rows[:, 2])  # of all DOFs, which have a diagonal entry each
    dof_file = path.with_suffix(".dof")
    if not dof_file.is_file():
        return Named(matrix)
    words = read_text(dof_file).split()
    try:
        pairs = np.array([word.split(".") for word in words], dtype=np.int64)
    except ValueError as error:
        raise SlipmodeError(f"{dof_file}: is damaged: lines must be NODE.DIRECTION") from error
    if matrix.shape[0] != len(pairs):
        raise SlipmodeError(
            f"{path}: has {matrix.shape[0]} DOFs, but {dof_file.name} has {len(pairs)}"
        )
    return Named(matrix, Labels(pairs[:, 0], pairs[:, 1]))


def _matrix_market(text: str) -> Any:

    header, _, body = text.lstrip().partition("\n")
    words = header.lower().split()[1:]
    if "pattern" in words:
        raise DamagedError("has places without values")
    # scipy's parser reads 1.5D+05 as 1.5, and refuses comments after the numbers
    if has_fortran_exponents(body) or "\n%" in body:
        lines = (line for line in body.splitlines() if line.strip() and line[0] != "%")
        body = with_plain_exponents("\n".join(lines))
    # It reads past the end of a damaged last line that has no line break
    plain = f"%%MatrixMarket {' '.join(words)}\n{body}\n"
    return scipy.io.mmread(BytesIO(plain.encode("ascii", "replace")), spmatrix=False)


def _substructure(text: str, path: Path) -> dict[str, Any]:
    """*SUBSTRUCTURE MATRIX OUTPUT: *USER ELEMENT, then lower triangles row by row.

    The nodes are in comments below ELEMENT NODES. The next line has the directions of the first
    node. Further lines have a position among the nodes and the directions from there on.
    """
    head, *blocks = _ELEMENT_MATRIX.split(text)
    kinds, contents = blocks[::2], blocks[1::2]
    if len(set(kinds)) < len(kinds):
        raise SlipmodeError(
            f"{path}: has the matrices of several elements; write those of the structure: *MATRIX "
            "GENERATE, or *SUBSTRUCTURE MATRIX OUTPUT"
        )
    pairs = _element_dofs(head)
    found = {}
    for kind, content in zip(kinds, contents, strict=True):
        if kind not in _PARTS:
            _log.warning("%s: the matrix of type %s is left out", path, kind)
            continue
        lines = (line for line in content.splitlines()[1:] if not line.startswith("**"))
        rows = takewhile(lambda line: not line.startswith("*"), lines)
        data = " ".join(rows).replace(",", " ").split()
        size = len(pairs) or round(np.sqrt(2 * len(data) + 0.25) - 0.5)
        if len(data) == size * size:
            matrix = numbers(data, size * size).reshape(size, size).T
        else:
            matrix = np.zeros((size, size))
            matrix[np.tril_indices(size)] = numbers(data, size * (size + 1) // 2)
            matrix += np.tril(matrix, -1).T
        labels = Labels(*pairs.T) if len(pairs) else None
        found[_PARTS[kind]] = Named(matrix, labels)
    return found


def _element_dofs(head: str) -> NDArray[np.int64]:
    """Return node and direction of each DOF (n, 2) of a *USER ELEMENT; empty without nodes."""
    nodes: list[int] = []
    lists: list[list[int]] = []
    listed = False
    for line in head.splitlines():
        words = re.findall(r"\d+", line)
        if line.startswith("**"):
            listed = "ELEMENT NODES" in line or (listed and not re.search("[A-Z]", line))
            nodes += [int(word) for word in words] if listed else []
        elif words and not line.startswith("*"):
            lists.append([int(word) for word in words])
    if not nodes or not lists:
        return np.zeros((0, 2), dtype=np.int64)
    directions = {1: lists[0]} | {first: rest for first, *rest in lists[1:]}
    latest = directions[1]
    pairs = []
    for position, node in enumerate(nodes, 1):
        latest = directions.get(position, latest)
        pairs += [(node, direction) for direction in latest]
    return np.array(pairs, dtype=np.int64)


def _rows(text: str, columns: tuple[int, ...], path: Path) -> NDArray[np.float64]:
    """Return the rows of a text (rows, columns); lines that begin with * are comments."""
    lines = "".join(f"{line}\n" for line in text.splitlines() if not line.lstrip().startswith("*"))
    if not text.endswith("\n"):
        _log.warning("%s: the last line does not end; check that the file is complete", path)
    if not lines.strip():
        raise DamagedError("has no numbers")
    lines = with_plain_exponents(lines.replace(",", " "))
    found = np.loadtxt(StringIO(lines), comments=None, ndmin=2)
    if found.size == 0 or found.shape[1] not in columns:
        raise DamagedError(f"rows must have {' or '.join(map(str, columns))} numbers")
    return found
