"""What is seen of a mesh from outside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# corners of each face, counter-clockwise as seen from outside
_FACES = {
    4: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    8: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}
CORNERS = tuple(_FACES)


def skin(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """Facets that one cell alone has.

    Parameters
    ----------
    cells : (cells, 4 or 8) ndarray of int
        Tetrahedra; hexahedra, the lower four corners first, as Abaqus and VTK order them.

    Returns
    -------
    (facets, 3 or 4) ndarray of int
        Counter-clockwise as seen from outside.
    """
    cells = np.asarray(cells)
    faces = cells[:, _FACES[cells.shape[1]]]
    faces = faces.reshape(-1, faces.shape[-1])
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(faces[np.sort(first[count == 1])])


def triangles(facets: NDArray[np.intp]) -> NDArray[np.intp]:
    """Facets (facets, 3 or 4) as triangles (triangles, 3)."""
    if facets.shape[1] == 3:
        return facets
    return facets[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
