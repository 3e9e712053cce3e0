"""Readers of the matrix files of other programs.

A reader returns one matrix (`Named`), or a dict of several by the names that the file gives them.
Readers import their packages when they are called, because these take a while to import.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.structure.labels import Labels
from slipmode.rom.text import read_text


@dataclass(frozen=True, eq=False)
class Named:
    """A matrix and, where the file has them, the labels of its rows."""

    matrix: Any
    labels: Labels | None = None


def read_matrix_market(path: Path) -> Any:
    """Return the matrix of a Matrix Market file."""
    from scipy.io import mmread

    # scipy's parser reads past the end of a damaged last line that has no line break.
    return mmread(BytesIO(f"{read_text(path)}\n".encode()), spmatrix=False)


def abaqus_mass_file(path: Path) -> Path:
    """Return JOB_MASS1.mtx for JOB_STIF2.mtx of the same Abaqus job; the path itself if none."""
    stem, separator, _ = path.stem.rpartition("_STIF")
    found = sorted(path.parent.glob(f"{stem}_MASS*.mtx")) if separator else []
    return found[0] if len(found) == 1 else path


def mirrored(matrix: Any) -> Any:
    """Return the whole symmetric matrix (CSC) if one triangle is given, else the matrix."""
    off = scipy.sparse.csc_array(scipy.sparse.triu(matrix, 1) + scipy.sparse.tril(matrix, -1))
    pattern = scipy.sparse.csc_array((np.ones(off.nnz), off.indices, off.indptr), shape=off.shape)
    both_triangles = pattern.multiply(pattern.T).nnz > 0
    return scipy.sparse.csc_array(matrix if both_triangles else matrix + off.T)


def _read_mtx(path: Path) -> Named:
    """Matrix Market, or *MATRIX GENERATE of Abaqus in any format of *MATRIX OUTPUT.

    MATRIX INPUT and LABELS name nodes and directions, COORDINATE has rows and columns. DOFs that
    boundary conditions hold have 1E36 on the diagonal.
    """
    with path.open("rb") as file:
        if b"%%MatrixMarket" in file.read(17):  # after a byte order mark
            return Named(read_matrix_market(path))
    numbers = _read_numbers(path, (3, 5), "Abaqus matrix file")
    if numbers.shape[1] == 3:
        return Named(_symmetric(numbers[:, :2], numbers[:, 2]))
    ends = numbers[:, :4].astype(np.int64).reshape(-1, 2)  # both ends of each entry in turn
    pairs, index = np.unique(ends, axis=0, return_inverse=True)
    matrix = _symmetric(index.reshape(-1, 2) + 1, numbers[:, 4], len(pairs))
    return Named(matrix, Labels(pairs[:, 0], pairs[:, 1]))


def _read_calculix(path: Path) -> Named:
    """.sti or .mas of *FREQUENCY, SOLVER=MATRIXSTORAGE; labels from the job's .dof file."""
    numbers = _read_numbers(path, (3,), "CalculiX matrix file")
    dof_file = path.with_suffix(".dof")
    if not dof_file.is_file():
        return Named(_symmetric(numbers[:, :2], numbers[:, 2]))
    words = read_text(dof_file).split()
    try:
        pairs = np.array([word.split(".") for word in words], dtype=np.int64)
    except ValueError as error:
        raise SlipmodeError(f"{dof_file}: is damaged: lines must be NODE.DIRECTION") from error
    matrix = _symmetric(numbers[:, :2], numbers[:, 2], len(pairs))
    if matrix.shape[0] != len(pairs):
        raise SlipmodeError(
            f"{path}: has {matrix.shape[0]} DOFs, but {dof_file.name} has {len(pairs)}"
        )
    return Named(matrix, Labels(pairs[:, 0], pairs[:, 1]))


def _read_harwell_boeing(path: Path) -> Named:
    """Harwell-Boeing, as Ansys writes it (HBMAT)."""
    from scipy.io import hb_read

    return Named(mirrored(hb_read(path, spmatrix=False)))


def _read_mat(path: Path) -> dict[str, Any]:
    """Variables of a MATLAB file."""
    from scipy.io import loadmat

    try:
        return {name: value for name, value in loadmat(path).items() if name[:2] != "__"}
    except NotImplementedError as error:
        raise SlipmodeError(f"{path}: is a MATLAB -v7.3 file; save it with -v7") from error


def _read_op4(path: Path) -> dict[str, Any]:
    """Matrices of a Nastran OUTPUT4 file, by pyYeti."""
    op4 = extra("pyyeti.nastran.op4", "nastran")
    loaded = op4.OP4().load(str(path), sparse=True)
    return {name: entry[0] for name, entry in loaded.items()}


def _read_dmig(path: Path) -> dict[str, Any]:
    """Matrices of DMIG cards in a Nastran punch file, by pyYeti."""
    bulk = extra("pyyeti.nastran.bulk", "nastran")
    found = {}
    for name, frame in bulk.rddmig(str(path), square=True).items():
        pairs = np.array(frame.index.to_list(), dtype=np.int64)
        # Scalar points have component 0: one direction of their own.
        found[name] = Named(frame.to_numpy(), Labels(pairs[:, 0], pairs[:, 1]))
    return found


def _read_full(path: Path) -> dict[str, Any]:
    """Stiffness and mass of an Ansys .full file without its held DOFs, by PyMAPDL Reader."""
    reader = extra("ansys.mapdl.reader.full", "ansys")
    # Words 127 and 128 are the length of the file in words of 4 bytes, low word first (Ansys'
    # fdfull.inc). The reader would read past the end of a shorter file.
    ends = np.fromfile(path, "<u4", 129)[127:]
    if ends.size < 2 or path.stat().st_size < 4 * (int(ends[0]) + (int(ends[1]) << 32)):
        raise SlipmodeError(f"{path}: is incomplete, or not a .full file of Ansys")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a missing matrix: read_external refuses it
        pairs, stiffness, mass = reader.FullFile(str(path)).load_km()
    if stiffness is None:
        return {}
    free = np.flatnonzero(stiffness.diagonal())
    node, direction = pairs[free].astype(np.int64).T
    labels = Labels(node, direction + 1)  # x is 0 there
    return {
        name: Named(mirrored(half)[free][:, free], labels)
        for name, half in (("stiffness", stiffness), ("mass", mass))
        if half is not None
    }


READERS: dict[str, Callable[[Path], Named | dict[str, Any]]] = {
    ".mtx": _read_mtx,
    ".sti": _read_calculix,
    ".mas": _read_calculix,
    ".hb": _read_harwell_boeing,
    ".rsa": _read_harwell_boeing,
    ".rua": _read_harwell_boeing,
    ".matrix": _read_harwell_boeing,
    ".mat": _read_mat,
    ".op4": _read_op4,
    ".pch": _read_dmig,
    ".full": _read_full,
}


def _read_numbers(path: Path, columns: tuple[int, ...], kind: str) -> NDArray[np.float64]:
    """Return the rows of a text file (rows, columns); lines that begin with * are comments."""
    try:
        text = read_text(path).replace(",", " ").replace("D", "E")
        numbers = np.loadtxt(StringIO(text), comments="*", ndmin=2)
    except (ValueError, OSError) as error:
        reason = " ".join(str(error).split())
        raise SlipmodeError(f"{path}: is damaged or not a {kind}: {reason}") from error
    if numbers.size == 0 or numbers.shape[1] not in columns:
        allowed = " or ".join(map(str, columns))
        raise SlipmodeError(f"{path}: is not a {kind}, whose rows have {allowed} numbers")
    return numbers


def _symmetric(places: NDArray[Any], values: NDArray[Any], size: int = 0) -> Any:
    """Return the symmetric matrix of entries at (row, column), from 1; one triangle may do."""
    rows, columns = places.astype(np.int64).T - 1
    size = max(size, int(max(rows.max(), columns.max())) + 1)
    return mirrored(scipy.sparse.coo_array((values, (rows, columns)), shape=(size, size)))
