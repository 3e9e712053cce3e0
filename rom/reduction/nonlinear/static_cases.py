"""Coefficients of the nonlinear stiffness from static load cases of a finite-element program.

With the modes phi and the forces f on all DOFs at a static displacement u, q = phi^T M u and

    phi^T f - omega^2 q = F(q) = dU / dq.

Under forces M phi c the other modes follow statically (implicit condensation). Displacements phi q
without other modes are enforced modal displacements. The equations are the same.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from math import factorial

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import Finding, SlipmodeError, warn
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import percentage

_RANK = 1e-6  # smallest singular value relative to the largest: a rounded coefficient below
_MOST_RESIDUAL = 0.05  # of the nonlinear forces [-]; larger ones are reported


def fit_nonlinear_stiffness(
    reduced: Reduced, displacements: ArrayLike, forces: ArrayLike
) -> dict[str, float]:
    """Return quadratic and cubic coefficients of modes from static load cases, by least squares.

    Parameters
    ----------
    reduced : Reduced
        Modes to which the coefficients belong, from `rom.reduce`.
    displacements : (cases, n) array_like
        Nonlinear static displacements of all DOFs with stuck contacts [m].
    forces : (cases, n) array_like
        Forces that hold the structure there [N]: loads, and reactions where displacements are
        enforced.

    Returns
    -------
    {str: float}
        Coefficients for `rom.with_nonlinear_stiffness`.

    Raises
    ------
    SlipmodeError
        If the arrays do not fit the structure, or the cases do not determine all coefficients.

    Warns
    -----
    ValidityWarning
        If the coefficients leave more than 5 % of the nonlinear forces.

    Notes
    -----
    The coefficients are derivatives of one potential. Loads M phi c, with c of both signs and of
    different sizes, and of both modes together, determine them best. They should bend the
    structure about as far as it vibrates.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> q = np.array([[-2.0], [-1.0], [1.0], [2.0]])
    >>> shape = reduced.mode_shapes.T
    >>> forces = (q + 0.01 * q**3) @ shape @ rom.two_mass().mass
    >>> coefficients = rom.fit_nonlinear_stiffness(reduced, q @ shape, forces)
    >>> round(coefficients["AAAA"], 6)
    0.01
    """
    if reduced.structure is None:
        raise SlipmodeError("reduced: must be from rom.reduce, with its structure")
    u, f = as_floats("displacements", displacements), as_floats("forces", forces)
    if u.ndim != 2 or u.shape != f.shape or u.shape[1] != reduced.n_dofs:
        raise SlipmodeError(
            f"displacements, forces: must have shape (cases, {reduced.n_dofs}), got {u.shape} and "
            f"{f.shape}"
        )
    phi = reduced.mode_shapes
    q = np.asarray(u @ (reduced.structure.mass @ phi))
    nonlinear = f @ phi - reduced.frequency**2 * q
    size = np.maximum(np.abs(q).max(axis=0), np.finfo(float).tiny)
    names = [
        "".join("AB"[k] for k in letters)
        for order in (3, 4)
        for letters in combinations_with_replacement(range(len(size)), order)
    ]
    columns = np.array([_force(name, q / size) / size for name in names])
    matrix = columns.reshape(len(names), -1).T
    found, _, rank, _ = np.linalg.lstsq(matrix, nonlinear.ravel(), rcond=_RANK)
    if rank < len(names):
        raise SlipmodeError(
            f"displacements: {len(u)} load cases do not determine the {len(names)} coefficients "
            f"{', '.join(names)}; add cases of both signs, sizes and modes"
        )
    missed = np.linalg.norm(matrix @ found - nonlinear.ravel())
    left = float(missed / np.linalg.norm(nonlinear))
    if left > _MOST_RESIDUAL:
        reason = "terms of higher order, or of other modes, matter; load the structure less"
        choice = f"leave {percentage(left)} of the nonlinear forces"
        warn([Finding("coefficients", choice, reason, "warning")])
    scales = [np.prod([size["AB".index(letter)] for letter in name]) for name in names]
    return dict(zip(names, (found / scales).tolist(), strict=True))


def _force(name: str, q: Floats) -> Floats:
    """Return the forces (cases, modes) of a coefficient 1 at displacements (cases, modes)."""
    powers = np.array([name.count(letter) for letter in "AB"[: q.shape[1]]])
    orders = factorial(len(name)) / np.prod([factorial(k) for k in powers])
    forces = np.zeros_like(q)
    for j, power in enumerate(powers):
        if power:
            lower = np.prod(q ** (powers - (np.arange(len(powers)) == j)), axis=1)
            forces[:, j] = orders / len(name) * power * lower
    return forces
