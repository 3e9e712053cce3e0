"""A blade of trilinear hexahedra, as large as is asked for, with contacts on one of its faces."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom.arrays import Floats

_E, _NU, _RHO = 2.0e11, 0.3, 7800.0  # [Pa], [-], [kg/m^3]
_LENGTH, _WIDTH, _THICKNESS = 0.2, 0.1, 0.008  # [m]
_ACROSS = 8  # elements through the thickness


def blade(dofs: int, contacts: int) -> dict[str, Any]:
    """Matrices of a blade of about so many DOFs, clamped at one end, eight elements thick.

    Elements of a box are products of line elements, so the matrices are sums of Kronecker
    products of those of three lines; integrated exactly.

    Parameters
    ----------
    dofs : int
        About how many.
    contacts : int
        Spread over one of the wide faces; each is a DOF in its plane, along the blade.

    Returns
    -------
    dict
        "mass", "stiffness" (sparse), "contact" (DOF indices).
    """
    columns = max(2, round(np.sqrt(dofs / (3 * (_ACROSS + 1) * 2))))
    cells = (2 * columns, columns, _ACROSS)
    lines = [
        _line(count, length / count)
        for count, length in zip(cells, (_LENGTH, _WIDTH, _THICKNESS), strict=True)
    ]
    gradients = {(a, b): _integral(lines, a, b) for a in range(3) for b in range(3)}
    lame = _E * _NU / ((1 + _NU) * (1 - 2 * _NU))
    shear = _E / (2 * (1 + _NU))
    laplacian = sum(gradients[a, a] for a in range(3))
    stiffness: Any = 0.0
    for (a, b), gradient in gradients.items():
        block = lame * gradient + shear * gradients[b, a] + (shear * laplacian if a == b else 0.0)
        place = scipy.sparse.csr_array(([1.0], ([a], [b])), shape=(3, 3))
        stiffness = scipy.sparse.kron(block, place, "csr") + stiffness
    mass = scipy.sparse.kron(_RHO * _integral(lines, None, None), np.eye(3), "csr")
    nodes = np.arange(mass.shape[0] // 3).reshape([count + 1 for count in cells])
    clamped = 3 * nodes[0].size
    along = max(1, round(np.sqrt(2 * contacts)))
    face = nodes[1:, :, -1]
    rows = np.linspace(0, len(face) - 1, along).astype(int)
    across = np.linspace(0, face.shape[1] - 1, -(-contacts // along)).astype(int)
    touching = face[np.ix_(rows, across)].ravel()[:contacts]
    return {
        "mass": mass[clamped:, clamped:],
        "stiffness": stiffness[clamped:, clamped:],
        "contact": 3 * touching - clamped,
    }


def _line(count: int, h: float) -> tuple[Any, Any, Any]:
    """Integrals of N_i N_j, N_i' N_j and N_i' N_j' over a line of elements of length h [m]."""
    return (
        _assembled(h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]]), count),
        _assembled(0.5 * np.array([[-1.0, -1.0], [1.0, 1.0]]), count),
        _assembled(np.array([[1.0, -1.0], [-1.0, 1.0]]) / h, count),
    )


def _assembled(element: Floats, count: int) -> Any:
    diagonal = np.full(count + 1, element[0, 0] + element[1, 1])
    diagonal[0], diagonal[-1] = element[0, 0], element[1, 1]
    below, above = np.full(count, element[1, 0]), np.full(count, element[0, 1])
    bands: Any = scipy.sparse.diags_array([below, diagonal, above], offsets=[-1, 0, 1])
    return scipy.sparse.csr_array(bands)


def _integral(lines: list[tuple[Any, Any, Any]], a: int | None, b: int | None) -> Any:
    """Of dN_i/dx_a dN_j/dx_b over the box; N itself where the axis is None."""
    product: Any = np.eye(1)
    for axis, (plain, slope, slopes) in enumerate(lines):
        if axis == a == b:
            factor = slopes
        elif axis == a:
            factor = slope
        elif axis == b:
            factor = slope.T
        else:
            factor = plain
        product = scipy.sparse.kron(product, factor, "csr")
    return product
