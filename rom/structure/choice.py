"""Which of the matrices of a file are the mass, the stiffness and the damping, by their names."""

from __future__ import annotations

import logging
import re
from collections.abc import Collection, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.readers.named import Named

_log = logging.getLogger(__name__)

#: The names of each matrix, the plainest first: its own; KGG, KAAX and others of Nastran, with a
#: set of DOFs; names in other programs. Patterns apply to the last part of a name such as sys.K.
_PATTERNS = {
    "stiffness": (r"stiffness$", r"k([adfghjlnqtvx])\1", r"(k(?!4)|stiff)|.*_k$|.*(?-i:[a-z]K)$"),
    "mass": (r"mass$", r"m([adfghjlnqtvx])\1", r"m|.*_m$|.*(?-i:[a-z]M)$"),
    "damping": (r"damping$", r"b([adfghjlnqtvx])\1", r"[bcd]"),
}
_STRUCTURAL_DAMPING = r"k4([adfghjlnqtvx])\1"  # of Nastran, K'' = stiffness times loss factor
_CONTACT = ("contact", "w")

#: Asymmetry of a mass or stiffness matrix, relative to its largest entry, due to rounded exports.
ROUNDED = 1e-6


def choose(
    found: Mapping[str, Any], path: Path, names: Mapping[str, str], wanted: Collection[str]
) -> dict[str, Any]:
    """Return the matrices of a file by "stiffness", "mass", "damping" and "contact".

    "loss" is structural damping beside a stiffness. The parts in `wanted` are looked for, and need
    not be there, "loss" with "damping". Given `names` come first.
    Otherwise mass, stiffness and damping are square, of one size, and have a name that fits. If
    several fit, asymmetric matrices are left out. Refuses what is still ambiguous.
    """
    chosen = {role: found[_key(role, name, found, path)] for role, name in names.items()}
    square = {name: value for name, value in found.items() if _size(value)}
    if max(map(_size, square.values()), default=0) > 1:  # then numbers are not matrices
        square = {n: each for n, each in square.items() if _size(each) > 1 or _is_labelled(each)}
    roles = [role for role in ("stiffness", "mass") if role in wanted and role not in names]
    options = [_fitting(role, square) for role in roles]
    _choose_together(chosen, roles, options, square, path)
    size = _size(chosen.get("stiffness"))
    if "damping" in wanted and "damping" not in chosen and size:
        same = {n: each for n, each in square.items() if _size(each) == size or _is_labelled(each)}
        dampers = [name for name in _fitting("damping", same) if _may_damp(name, same, path)]
        if len(dampers) > 1:
            raise _ambiguous("damping", dampers, square, path)
        if dampers:
            chosen["damping"] = square[dampers[0]]
        losses = [n for n in same if re.match(_STRUCTURAL_DAMPING, _last(n), re.IGNORECASE)]
        if len(losses) > 1:
            raise _ambiguous("structural damping", losses, square, path)
        if losses:
            chosen["loss"] = square[losses[0]]
    if "contact" in wanted and "contact" not in chosen:
        contacts = [name for name in found if _last(name).lower() in _CONTACT]
        if contacts:
            chosen["contact"] = found[contacts[0]]
    return chosen


def _choose_together(
    chosen: dict[str, Any],
    roles: list[str],
    options: list[list[str]],
    square: Mapping[str, Any],
    path: Path,
) -> None:
    """Choose matrices of one size for the roles that have options."""
    roles = [role for role, names in zip(roles, options, strict=True) if names]
    options = [names for names in options if names]
    given = [_size(value) for value in chosen.values() if _size(value)]
    labelled = any(_is_labelled(square[name]) for names in options for name in names)

    def fit(names: tuple[str, ...]) -> bool:
        return labelled or len({*given, *(_size(square[name]) for name in names)}) == 1

    together = [names for names in product(*options) if fit(names)]
    if not together:  # sizes that differ are refused where the matrices are assembled
        together = list(product(*options))
    if len(together) > 1:
        plain = [names for names in together if all(_is_plain(square[name]) for name in names)]
        together = plain or together
    for k, role in enumerate(roles):
        names = sorted({each[k] for each in together})
        if len(names) > 1:
            raise _ambiguous(role, names, square, path)
        chosen[role] = square[names[0]]


def _key(role: str, name: str, found: Mapping[str, Any], path: Path) -> str:
    """Return the name of a matrix in the file, which may be given in other letters."""
    if role not in (*_PATTERNS, "contact"):
        allowed = ", ".join((*_PATTERNS, "contact"))
        raise SlipmodeError(f"names: must be of {allowed}, got {role!r}")
    same = [each for each in found if each == name] or [
        each for each in found if each.lower() == str(name).lower()
    ]
    if len(same) != 1:
        raise SlipmodeError(
            f"{path}: names: {role} = {name!r} is not in the file, which has {listed(found)}"
        )
    if found[same[0]] is None:
        raise SlipmodeError(f"{path}: {same[0]} is damaged or not a plain array")
    return same[0]


def _fitting(role: str, square: Mapping[str, Any]) -> list[str]:
    """Return the names that fit the plainest pattern of a role."""
    for pattern in _PATTERNS[role]:
        fitting = [
            name
            for name in square
            if re.match(pattern, _last(name), re.IGNORECASE)
            and not any(
                re.match(other[0], _last(name), re.IGNORECASE)
                for key, other in _PATTERNS.items()
                if key != role
            )
        ]
        if fitting:
            return fitting
    return []


def _may_damp(name: str, square: Mapping[str, Any], path: Path) -> bool:
    """Return whether a matrix may be the damping; say why not."""
    matrix = square[name]
    last = _last(name).lower()
    if not _is_plain(matrix):
        reason = "is not symmetric"
    elif last == "d" and _is_diagonal(matrix):
        reason = "is diagonal, as matrices of eigenvalues are"
    else:
        return True
    _log.warning(
        '%s: %s %s, and is not taken for the damping; names={"damping": "%s"} takes it',
        path, name, reason, name,
    )  # fmt: skip
    return False


def _is_labelled(value: Any) -> bool:
    return isinstance(value, Named) and value.labels is not None


def _last(name: str) -> str:
    """Return the last part of a name such as sys.K."""
    return name.rpartition(".")[2]


def _size(value: Any) -> int:
    """Return the number of rows of a square matrix of numbers; 0 for anything else."""
    matrix = value.matrix if isinstance(value, Named) else value
    shape: Any = getattr(matrix, "shape", ())
    dtype = getattr(matrix, "dtype", None)
    if len(shape) != 2 or shape[0] != shape[1] or dtype is None or dtype.kind not in "iufc":
        return 0
    return int(shape[0])


def _is_plain(value: Any) -> bool:
    """Return whether a square matrix may be a mass, stiffness or damping: symmetric, K_ii >= 0."""
    matrix: Any = value.matrix if isinstance(value, Named) else value
    matrix = matrix * 1.0  # differences of unsigned integers would overflow
    asymmetry = abs(matrix - matrix.T).max()
    return bool(asymmetry <= ROUNDED * abs(matrix).max() and (matrix.diagonal().real >= 0).all())


def _is_diagonal(value: Any) -> bool:
    matrix = scipy.sparse.csc_array(value.matrix if isinstance(value, Named) else value)
    return bool(matrix.count_nonzero() == np.count_nonzero(matrix.diagonal()))


def _ambiguous(
    role: str, names: list[str], square: Mapping[str, Any], path: Path
) -> SlipmodeError:
    options = ", ".join(f"{name} ({_size(square[name])} DOFs)" for name in names)
    return SlipmodeError(
        f'{path}: {options} may each be {role}; choose one: names={{"{role}": "{names[0]}"}}'
    )


def listed(found: Mapping[str, Any]) -> str:
    """Return the names of a file, the first twenty."""
    names = list(found)
    return ", ".join(names[:20]) + (", ..." if len(names) > 20 else "") if names else "no matrix"
