"""Force amplitudes of all DOFs, as users give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.representable import ALLOWED, LARGEST, SMALLEST


def force_vector(
    force: Mapping[int, float] | ArrayLike, n_dofs: int, key: str = "force"
) -> Floats:
    """Return force amplitudes (n,) from {DOF: amplitude} or an array; a refusal names `key`."""
    if isinstance(force, Mapping):
        vector = np.zeros(n_dofs)
        for dof, amplitude in force.items():
            if not (isinstance(dof, int | np.integer) and 0 <= dof < n_dofs):
                raise SlipmodeError(
                    f"{key}: DOF {dof!r} is out of range, allowed: 0 to {n_dofs - 1}"
                )
            number = as_floats(key, amplitude)
            if number.ndim:
                raise SlipmodeError(f"{key}: must be one number at DOF {dof}, got {amplitude}")
            vector[dof] = number
    else:
        vector = as_floats(key, force)
    largest = float(np.abs(vector).max(initial=0.0))
    if vector.shape != (n_dofs,) or not (largest == 0.0 or SMALLEST <= largest <= LARGEST):
        raise SlipmodeError(
            f"{key}: must be {n_dofs} finite numbers, one per DOF, the largest {ALLOWED}"
        )
    return vector


def force_vectors(forces: Any, tones: int, n_dofs: int, key: str = "force") -> Floats:
    """Return forces (tones, n) of one {DOF: amplitude} or array per tone; refusals name `key`."""
    is_list = isinstance(forces, Sequence | np.ndarray) and not isinstance(forces, str)
    if not is_list or len(forces) != tones:
        raise SlipmodeError(
            f"{key}: needs one entry per mode ({tones}), each {{DOF: amplitude}} or an array of "
            f"{n_dofs} numbers, got {in_one_line(forces)}"
        )
    return np.array([force_vector(each, n_dofs, key) for each in forces])
