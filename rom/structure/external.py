"""Mass, stiffness, damping, contacts and labels from files of other programs."""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.choice import ROUNDED, choose, listed
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.readers.abaqus import abaqus_mass_file
from slipmode.rom.structure.readers.by_suffix import read_matrix_file
from slipmode.rom.structure.readers.named import Named

_log = logging.getLogger(__name__)

_MATRICES = ("stiffness", "mass", "damping", "contact")


def read_external(
    path: Path, mass: Path | None, names: Mapping[str, str], given: Collection[str]
) -> dict[str, Any]:
    """Read the matrices of a structure, and `labels` if the files have them.

    `path` is the file of the stiffness or of all matrices, `mass` the file of the mass; by default
    the file that the same job of Abaqus or CalculiX wrote. `names` name the matrices in
    the files. Parts that are `given` otherwise are not looked for. `empty` are DOFs that cannot
    move, because they have neither mass nor stiffness.
    """
    wanted = [part for part in _MATRICES if part not in given]
    own = {part: name for part, name in names.items() if part != "mass" or mass is None}
    parts = _parts(path, own, [part for part in wanted if part != "mass" or mass is None])
    if "mass" not in parts:
        file = _mass_file(path) if mass is None else mass
        theirs = {part: name for part, name in names.items() if part == "mass"}
        parts |= _parts(file, theirs, ["mass"])
    return _assembled(parts, path)


def _mass_file(path: Path) -> Path:
    """Return the file of the mass that the same job wrote."""
    file = path.with_suffix(".mas") if path.suffix.lower() == ".sti" else abaqus_mass_file(path)
    if file == path or not file.is_file():
        expected = "" if file == path else f" (there is no {file.name})"
        raise SlipmodeError(
            f"{path}: mass is missing{expected}; give its file: mass=, or its name if it is in "
            'this file: names={"mass": "..."}'
        )
    return file


def _parts(path: Path, names: Mapping[str, str], wanted: Sequence[str]) -> dict[str, Named]:
    """Return the matrices of a file that are wanted; the first of them must be there.

    A matrix without a name is the first one.
    """
    found = read_matrix_file(path)
    if isinstance(found, Named):
        if names:
            raise SlipmodeError(f"names: {path} has one matrix without a name; leave names out")
        return {wanted[0]: found}
    chosen = choose(found, path, names, wanted)
    if wanted[0] not in chosen:
        raise SlipmodeError(
            f"{path}: {wanted[0]} is missing; the file has {listed(found)}; name it: "
            f'names={{"{wanted[0]}": "..."}}'
        )
    return {
        part: value if isinstance(value, Named) else Named(value) for part, value in chosen.items()
    }


def _assembled(parts: dict[str, Named], path: Path) -> dict[str, Any]:
    """Return all matrices in the order of the stiffness, without the DOFs that are held."""
    contact = parts.pop("contact", None)
    labels, size = parts["stiffness"].labels, parts["stiffness"].matrix.shape[0]
    matrices = {
        name: _in_order(part, labels, size, f"{path}: {name}") for name, part in parts.items()
    }
    # Boundary conditions hold a DOF by a penalty of that stiffness [N/m] or more
    free = np.flatnonzero(matrices["stiffness"].diagonal().real < 1e30)
    if free.size < size:
        _log.warning(
            "%s: %d DOFs are fixed by boundary conditions and left out", path, size - free.size
        )
        matrices = {name: matrix[free][:, free] for name, matrix in matrices.items()}
        if labels is not None:
            labels = Labels(labels.node[free], labels.direction[free])
    empty = _hold_empty(matrices, path)
    if "loss" in matrices:
        matrices["stiffness"] = matrices["stiffness"] + 1j * matrices.pop("loss")
    found: dict[str, Any] = {
        name: _symmetrised(matrix, name, path) for name, matrix in matrices.items()
    }
    found["empty"] = empty
    if contact is not None:
        given = contact.matrix
        is_list = 1 in np.shape(given) and np.size(given) < size
        found["contact"] = given.ravel() if is_list else given
    return found if labels is None else found | {"labels": labels}


def _hold_empty(matrices: dict[str, Any], path: Path) -> NDArray[np.intp]:
    """Hold the DOFs that have neither mass nor stiffness, by springs, and return them.

    Rotations of solid elements are such. DOFs keep their numbers, as in the file.
    """
    K, M = matrices["stiffness"], matrices["mass"]
    loose = np.flatnonzero(K.diagonal() == 0)
    light = int(np.count_nonzero(M.diagonal() == 0)) - loose.size
    if light > 0:
        _log.warning(
            "%s: %d of %d DOFs have no mass; they follow statically", path, light, K.shape[0]
        )
    if not loose.size:
        return loose
    used = abs(K)[loose].sum(axis=1) + abs(M)[loose].sum(axis=1)
    if used.any():
        raise SlipmodeError(
            f"{path}: the diagonal of stiffness is 0 at {np.count_nonzero(used)} DOFs with mass, "
            f"the first is DOF {loose[used > 0][0]}; check that the file is complete"
        )
    springs = np.zeros(K.shape[0])
    springs[loose] = abs(K).max() or 1.0
    matrices["stiffness"] = scipy.sparse.csc_array(K + scipy.sparse.diags_array(springs))
    _log.warning(
        "%s: %d of %d DOFs have neither mass nor stiffness; they do not move, and keep their "
        "numbers",
        path, loose.size, K.shape[0],
    )  # fmt: skip
    return loose


def _in_order(part: Named, labels: Labels | None, size: int, key: str) -> Any:
    """Return a matrix with its rows in the order of the rows of the stiffness."""
    matrix: Any = part.matrix if scipy.sparse.issparse(part.matrix) else np.asarray(part.matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise SlipmodeError(f"{key}: must be square, got {matrix.shape}")
    if matrix.dtype.kind not in ("iufc" if key.endswith("stiffness") else "iuf"):
        raise SlipmodeError(f"{key}: must hold real numbers, got {matrix.dtype}")
    matrix = scipy.sparse.csc_array(matrix)
    if part.labels is None or labels is None:
        if matrix.shape[0] != size:
            raise SlipmodeError(f"{key} has {matrix.shape[0]} DOFs, stiffness has {size}")
        return matrix
    places = labels.places(part.labels)
    if places.min(initial=0) < 0:
        node = part.labels.node[np.argmin(places)]
        raise SlipmodeError(f"{key}: node {node} has a DOF that is not in stiffness")
    entries = (np.ones(places.size), (places, np.arange(places.size)))
    selection = scipy.sparse.csc_array(entries, shape=(size, places.size))
    return selection @ matrix @ selection.T


def _symmetrised(matrix: Any, name: str, path: Path) -> Any:
    """Return the matrix without the asymmetry due to rounded exports."""
    largest = abs(matrix).max()
    asymmetry = abs(matrix - matrix.T).max()
    if asymmetry == 0.0 or asymmetry > ROUNDED * largest:
        return matrix
    message = (
        "%s: %s is symmetrised: entries differ from their mirror images by %.1e of the largest"
    )
    _log.warning(message, path, name, asymmetry / largest)
    return 0.5 * (matrix + matrix.T)
