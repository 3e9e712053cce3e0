"""Mass, stiffness, damping and labels from files of other programs."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.formats import (
    abaqus,
    ansys,
    calculix,
    harwell_boeing,
    matlab,
    nastran,
)
from slipmode.rom.structure.formats.triplets import Named
from slipmode.rom.structure.labels import Labels

_log = logging.getLogger(__name__)

_HELD = 1e30  # stiffness [N/m] of DOFs that boundary conditions hold by a penalty
_ROUNDING = 1e-6  # asymmetry that is rounding of exports, relative to the largest entry
#: Words for the matrices, and how their short names begin in Nastran, MATLAB and elsewhere.
_NAMES = {"mass": ("m",), "stiffness": ("k",), "damping": ("b", "c", "d")}
_CONTACT = ("contact", "w")

_ONE: dict[str, Callable[[Path], Named]] = {
    ".mtx": abaqus.read,
    ".sti": calculix.read,
    ".mas": calculix.read,
    ".hb": harwell_boeing.read,
    ".rsa": harwell_boeing.read,
    ".rua": harwell_boeing.read,
    ".matrix": harwell_boeing.read,
}
_SEVERAL: dict[str, Callable[[Path], dict[str, Any]]] = {
    ".mat": matlab.read,
    ".op4": nastran.read_op4,
    ".pch": nastran.read_dmig,
    ".full": ansys.read_full,
}
ENDINGS = (*_ONE, *_SEVERAL)


def read_external(path: Path, mass: Path | None) -> dict[str, Any]:
    """The matrices of a structure, and `labels` where the files have them.

    Parameters
    ----------
    path : path
        Of the stiffness, or of a file that has all.
    mass : path, optional
        Of the mass; by default the file that the same job of Abaqus or CalculiX wrote.
    """
    parts = _parts(path)
    if mass is None and "mass" not in parts:
        mass = _mass_beside(path)
    if mass is not None:
        parts["mass"] = _part(_parts(mass, "mass"), mass, "mass")
    for name in ("stiffness", "mass"):
        _part(parts, path, name)
    return _as_one(parts, path)


def _part(parts: Mapping[str, Named], path: Path, name: str) -> Named:
    if name not in parts:
        raise SlipmodeError(f"{path}: {name} is missing; give its file: {name}=")
    return parts[name]


def _mass_beside(path: Path) -> Path:
    """The file of the mass."""
    beside = {".sti": path.with_suffix(".mas"), ".mtx": abaqus.mass_beside(path)}.get(path.suffix)
    if beside is None or beside == path or not beside.is_file():
        expected = "" if beside in (None, path) else f" ({beside.name} is not there)"
        raise SlipmodeError(f"{path}: mass is missing{expected}; give its file: mass=")
    return beside


def _parts(path: Path, name: str = "stiffness") -> dict[str, Named]:
    """What a file has; `name` is what a file of one matrix is."""
    if not path.is_file():
        raise SlipmodeError(f"{path}: no such file")
    ending = path.suffix.lower()
    try:
        if ending == ".mtx" and _is_matrix_market(path):
            return {name: Named(_matrix_market(path))}
        if ending in _ONE:
            return {name: _ONE[ending](path)}
        if ending in _SEVERAL:
            return _named(_SEVERAL[ending](path), path)
    except SlipmodeError:
        raise
    except Exception as error:  # damaged files make parsers raise nearly anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise SlipmodeError(f"{path}: {name} cannot be read: {reason}") from error
    raise SlipmodeError(f"{path}: must end in .npz, {', '.join(ENDINGS)}, or be a folder")


def _is_matrix_market(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(14) == b"%%MatrixMarket"


def _matrix_market(path: Path) -> Any:
    from scipy.io import mmread

    return mmread(path, spmatrix=False)


def _named(found: Mapping[str, Any], path: Path) -> dict[str, Named]:
    """Matrices of a file under the names that they have here."""
    parts = {}
    for part, beginnings in _NAMES.items():
        names = [name for name in found if name.lower() == part] or [
            name
            for name in found
            if name.lower().startswith(beginnings) and name.lower() not in (*_NAMES, *_CONTACT)
        ]
        if len(names) > 1:
            raise SlipmodeError(f"{path}: {part} may be {', '.join(names)}; keep one of them")
        if names:
            value = found[names[0]]
            parts[part] = value if isinstance(value, Named) else Named(value)
    for name, value in found.items():
        if name.lower() in _CONTACT:
            parts["contact"] = Named(value)
    return parts


def _as_one(parts: dict[str, Named], path: Path) -> dict[str, Any]:
    """All matrices in the order of the stiffness, without the DOFs that are held."""
    contact = parts.pop("contact", None)
    labels, size = parts["stiffness"].labels, parts["stiffness"].matrix.shape[0]
    matrices = {name: _in_order(part, labels, size, name, path) for name, part in parts.items()}
    free = np.flatnonzero(matrices["stiffness"].diagonal() < _HELD)
    if free.size < size:
        _log.warning(
            "%s: %d DOFs are held by boundary conditions: left out", path, size - free.size
        )
        matrices = {name: matrix[free][:, free] for name, matrix in matrices.items()}
        if labels is not None:
            labels = Labels(labels.node[free], labels.direction[free])
    empty = np.flatnonzero(matrices["stiffness"].diagonal() == 0)
    if empty.size:
        raise SlipmodeError(
            f"{path}: stiffness has nothing at {empty.size} DOFs, the first DOF {empty[0]}: "
            "is the file whole?"
        )
    found: dict[str, Any] = {
        name: _symmetrised(matrix, name, path) for name, matrix in matrices.items()
    }
    if contact is not None:
        given = contact.matrix
        found["contact"] = (
            given.ravel() if 1 in np.shape(given) and np.size(given) < size else given
        )
    return found | ({} if labels is None else {"labels": labels})


def _in_order(part: Named, labels: Labels | None, size: int, name: str, path: Path) -> Any:
    """A matrix with its rows as those of the stiffness are."""
    matrix: Any = part.matrix if scipy.sparse.issparse(part.matrix) else np.asarray(part.matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise SlipmodeError(f"{path}: {name}: must be square, got {matrix.shape}")
    if matrix.dtype.kind not in "iuf":
        raise SlipmodeError(f"{path}: {name}: must hold real numbers, got {matrix.dtype}")
    matrix = scipy.sparse.csc_array(matrix)
    if part.labels is None or labels is None:
        if matrix.shape[0] != size:
            raise SlipmodeError(f"{path}: {name} has {matrix.shape[0]} DOFs, stiffness has {size}")
        return matrix
    places = labels.places(part.labels)
    if places.min(initial=0) < 0:
        node = part.labels.node[np.argmin(places)]
        raise SlipmodeError(f"{path}: {name}: node {node} has a DOF that stiffness has not")
    where = scipy.sparse.coo_array(
        (np.ones(places.size), (places, np.arange(places.size))), shape=(size, places.size)
    ).tocsc()
    return where @ matrix @ where.T


def _symmetrised(matrix: Any, name: str, path: Path) -> Any:
    """The matrix without the asymmetry that rounding of exports leaves."""
    largest = abs(matrix).max()
    apart = abs(matrix - matrix.T).max()
    if apart == 0.0 or apart > _ROUNDING * largest:
        return matrix
    _log.warning(
        "%s: %s is symmetrised: entries differ from their mirror images by %.1e of the largest",
        *(path, name, apart / largest),
    )
    return 0.5 * (matrix + matrix.T)
