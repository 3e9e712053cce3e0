"""Variables of a MATLAB workspace, of all versions, and arrays of a NumPy .npz file.

Variables in structs are named as MATLAB does, `sys.K`, or `sys(2).K` in an array of structs.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom.errors import SlipmodeError, one_line_reason
from slipmode.rom.extras import extra
from slipmode.rom.storage import stored_arrays
from slipmode.rom.structure.readers.named import Named

#: A sparse matrix `mass` in a .npz file is mass_data, mass_indices, ...
CSR_PARTS = ("data", "indices", "indptr", "shape")

_HDF5 = b"\x89HDF\r\n\x1a\n"
_MATLAB_HEADER = 512  # bytes of MATLAB before the HDF5 file of version 7.3


def read_mat(path: Path) -> dict[str, Any]:
    """Return the numeric variables of a MATLAB file by name."""
    with path.open("rb") as file:
        head = file.read(_MATLAB_HEADER + len(_HDF5))
    if head.startswith(_HDF5) or head.endswith(_HDF5):
        h5py = extra("h5py", "matlab")
        with h5py.File(path, "r") as file:
            return dict(_of_group(file, ""))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of objects and functions, which are left out
        variables = scipy.io.loadmat(path)
    return {
        name: value
        for variable, content in variables.items()
        if not variable.startswith("__")
        for name, value in _of_struct(content, variable)
    }


def read_npy(path: Path) -> Named:
    """Return the array of a .npy file."""
    with path.open("rb") as file:
        return Named(stored_arrays.read_npy(file, path.stat().st_size))


def read_npz(path: Path) -> Named | dict[str, Any]:
    """Return the arrays of a .npz file by name; None for an array that cannot be read.

    A sparse matrix `mass` is stored in compressed sparse rows as mass_data, mass_indices, ...
    """
    try:
        stored = stored_arrays.open_npz(path)
    except Exception as error:
        reason = one_line_reason(error)
        raise SlipmodeError(f"{path}: is not a readable .npz file: {reason}") from error
    with stored:
        if {"format", *CSR_PARTS} <= set(stored.files):  # written by scipy.sparse.save_npz
            return Named(scipy.sparse.load_npz(path))
        names = set(stored.files)
        sparse = {name.removesuffix("_indptr") for name in names if name.endswith("_indptr")}
        sparse = {name for name in sparse if {f"{name}_{part}" for part in CSR_PARTS} <= names}
        names -= {f"{name}_{part}" for name in sparse for part in CSR_PARTS}
        return {name: _of_npz(stored, name) for name in sorted(names | sparse)}


def _of_npz(stored: Mapping[str, Any], name: str) -> Any:
    """Return a stored matrix or number."""
    try:
        if name in stored:
            array = stored[name]
            return array if array.ndim else array.item()
        data, indices, indptr, shape = (stored[f"{name}_{part}"] for part in CSR_PARTS)
        matrix: Any = scipy.sparse.csr_array((data, indices, indptr), shape=tuple(shape))
        matrix.check_format(full_check=True)  # indices out of range would read foreign memory
    except Exception:  # damaged parts make zipfile, zlib, numpy and scipy raise nearly anything
        return None
    return matrix


def _of_struct(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Yield the numeric arrays in a variable by name."""
    if scipy.sparse.issparse(value):
        yield name, value
    elif not isinstance(value, np.ndarray):
        return
    elif value.dtype.names is not None:
        for k, each in enumerate(value.ravel(order="F")):
            numbered = name if value.size == 1 else f"{name}({k + 1})"
            for field in value.dtype.names:
                yield from _of_struct(each[field], f"{numbered}.{field}")
    elif value.dtype.kind in "biufc":
        yield name, value


def _of_group(group: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield the numeric arrays in an HDF5 group of MATLAB, whose arrays have the order of Fortran.

    A sparse matrix is a group with column pointers `jc`, rows `ir` and `data`.
    """
    for key, item in group.items():
        name = f"{prefix}{key}"
        if key.startswith("#"):  # contents of cells
            continue
        if "MATLAB_sparse" in item.attrs:
            starts = np.asarray(item["jc"]).astype(np.int64).ravel()
            rows, values = (
                np.asarray(item[part]).ravel() if part in item else np.zeros(0)
                for part in ("ir", "data")
            )
            shape = (int(item.attrs["MATLAB_sparse"]), starts.size - 1)
            matrix = scipy.sparse.csc_array((values, rows.astype(np.int64), starts), shape=shape)
            matrix.check_format(full_check=True)
            yield name, matrix
        elif hasattr(item, "items"):
            yield from _of_group(item, f"{name}.")
        elif item.dtype.names is not None:
            yield name, (item["real"] + 1j * item["imag"]).T
        elif item.dtype.kind in "biuf" and "MATLAB_empty" not in item.attrs:
            yield name, np.asarray(item).T
