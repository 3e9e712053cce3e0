"""Mass, stiffness, damping, contacts and labels from files of other programs."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.formats import READERS, Named, abaqus_mass_file
from slipmode.rom.structure.labels import Labels

_log = logging.getLogger(__name__)

#: The matrices, and how their short names begin in Nastran, MATLAB and other programs.
_NAMES = {"mass": ("m",), "stiffness": ("k",), "damping": ("b", "c", "d")}
_CONTACT = ("contact", "w")


def read_external(path: Path, mass: Path | None) -> dict[str, Any]:
    """Read the matrices of a structure, and `labels` if the files have them.

    `path` is the file of the stiffness or of all matrices, `mass` the file of the mass; by default
    the file that the same job of Abaqus or CalculiX wrote.
    """
    parts = _parts(path, "stiffness")
    if mass is None and "mass" not in parts:
        mass = _mass_file(path)
    if mass is not None:
        parts["mass"] = _part(_parts(mass, "mass"), mass, "mass")
    for name in ("stiffness", "mass"):
        _part(parts, path, name)
    return _assembled(parts, path)


def _part(parts: Mapping[str, Named], path: Path, name: str) -> Named:
    if name not in parts:
        raise SlipmodeError(f"{path}: {name} is missing; give its file: {name}=")
    return parts[name]


def _mass_file(path: Path) -> Path:
    """Return the file of the mass that the same job wrote."""
    file = path.with_suffix(".mas") if path.suffix == ".sti" else abaqus_mass_file(path)
    if file == path or not file.is_file():
        expected = "" if file == path else f" (there is no {file.name})"
        raise SlipmodeError(f"{path}: mass is missing{expected}; give its file: mass=")
    return file


def _parts(path: Path, name: str) -> dict[str, Named]:
    """Return the matrices of a file; `name` is the one that a file of one matrix has."""
    if not path.is_file():
        raise SlipmodeError(f"{path}: no such file")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise SlipmodeError(f"{path}: must end in .npz, {', '.join(READERS)}, or be a folder")
    try:
        found = reader(path)
    except SlipmodeError:
        raise
    except Exception as error:  # damaged files make parsers raise nearly anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SlipmodeError(f"{path}: {name} cannot be read: {reason}") from error
    return {name: found} if isinstance(found, Named) else _renamed(found, path)


def _renamed(found: Mapping[str, Any], path: Path) -> dict[str, Named]:
    """Return the matrices of a file under slipmode's names."""
    parts = {}
    for part, beginnings in _NAMES.items():
        names = [name for name in found if name.lower() == part] or [
            name
            for name in found
            if name.lower().startswith(beginnings) and name.lower() not in (*_NAMES, *_CONTACT)
        ]
        if len(names) > 1:
            raise SlipmodeError(f"{path}: {', '.join(names)} may each be {part}; keep one of them")
        if names:
            parts[part] = found[names[0]]
    for name, value in found.items():
        if name.lower() in _CONTACT:
            parts["contact"] = value
    return {
        part: value if isinstance(value, Named) else Named(value) for part, value in parts.items()
    }


def _assembled(parts: dict[str, Named], path: Path) -> dict[str, Any]:
    """Return all matrices in the order of the stiffness, without the DOFs that are held."""
    contact = parts.pop("contact", None)
    labels, size = parts["stiffness"].labels, parts["stiffness"].matrix.shape[0]
    matrices = {
        name: _in_order(part, labels, size, f"{path}: {name}") for name, part in parts.items()
    }
    # Boundary conditions hold a DOF by a penalty of that stiffness [N/m] or more
    free = np.flatnonzero(matrices["stiffness"].diagonal() < 1e30)
    if free.size < size:
        _log.warning(
            "%s: %d DOFs are fixed by boundary conditions and left out", path, size - free.size
        )
        matrices = {name: matrix[free][:, free] for name, matrix in matrices.items()}
        if labels is not None:
            labels = Labels(labels.node[free], labels.direction[free])
    empty = np.flatnonzero(matrices["stiffness"].diagonal() == 0)
    if empty.size:
        raise SlipmodeError(
            f"{path}: the diagonal of stiffness is 0 at {empty.size} DOFs, the first is DOF "
            f"{empty[0]}; check that the file is complete"
        )
    found: dict[str, Any] = {
        name: _symmetrised(matrix, name, path) for name, matrix in matrices.items()
    }
    if contact is not None:
        given = contact.matrix
        is_list = 1 in np.shape(given) and np.size(given) < size
        found["contact"] = given.ravel() if is_list else given
    return found if labels is None else found | {"labels": labels}


def _in_order(part: Named, labels: Labels | None, size: int, key: str) -> Any:
    """Return a matrix with its rows in the order of the rows of the stiffness."""
    matrix: Any = part.matrix if scipy.sparse.issparse(part.matrix) else np.asarray(part.matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise SlipmodeError(f"{key}: must be square, got {matrix.shape}")
    if matrix.dtype.kind not in "iuf":
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
    if asymmetry == 0.0 or asymmetry > 1e-6 * largest:
        return matrix
    message = (
        "%s: %s is symmetrised: entries differ from their mirror images by %.1e of the largest"
    )
    _log.warning(message, path, name, asymmetry / largest)
    return 0.5 * (matrix + matrix.T)
