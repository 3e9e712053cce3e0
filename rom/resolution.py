"""How finely to resolve the torus: steps and lines by doubling, until the answer stays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rom.errors import SlipmodeError
from rom.friction import Friction
from rom.matrices import Floats
from rom.reduction import Reduced
from rom.torus import Discretisation, friction_terms

# Fractions of the largest amplitudes at which resolution is tried: both modes strong, each
# strong over a weak one, and both near the slip threshold.
_PROBES = np.array([[1.0, 1.0], [1.0, 0.3], [0.3, 1.0], [0.6, 0.6], [0.35, 0.35], [0.25, 0.1]])
_STEPS = (32, 64, 128, 256, 512, 1024, 2048)
_LINES = (4, 8, 16, 32, 64, 128)


@dataclass(frozen=True)
class Resolution:
    """A discretisation and the error it was measured to have.

    Attributes
    ----------
    grid : Discretisation
    error : float
        Change of S on doubling both steps and lines, relative to the largest |S_j|.
    """

    grid: Discretisation
    error: float


def choose_resolution(
    reduced: Reduced, law: Friction, limit: Floats, tolerance: float
) -> Resolution:
    """Coarsest discretisation whose answer changes by less than `tolerance` when doubled.

    Raises
    ------
    SlipmodeError
        If 1024 steps per period do not suffice.
    """
    modes = limit.size
    points = _PROBES[:, :modes] * limit

    def solve(steps: int, lines: int) -> np.ndarray:
        grid = Discretisation(steps, lines)
        return friction_terms(reduced, law, points, grid, 0.1 * tolerance, limit)[0]

    def change(coarse: np.ndarray, fine: np.ndarray) -> float:
        scale = np.abs(fine).max(axis=0)
        return float((np.abs(fine - coarse).max(axis=0) / np.where(scale > 0, scale, 1.0)).max())

    lines = 1
    if modes == 2:
        coarse = solve(64, _LINES[0])
        for lines, finer in zip(_LINES[:-1], _LINES[1:], strict=True):
            fine = solve(64, finer)
            if change(coarse, fine) <= 0.5 * tolerance:
                break
            coarse = fine
    coarse = solve(_STEPS[0], lines)
    for steps, finer in zip(_STEPS[:-1], _STEPS[1:], strict=True):
        fine = solve(finer, lines)
        if change(coarse, fine) <= 0.5 * tolerance:
            doubled = solve(finer, 2 * lines if modes == 2 else 1)
            return Resolution(Discretisation(steps, lines), change(coarse, doubled))
        coarse = fine
    raise SlipmodeError(
        f"tolerance: {tolerance:g} needs more than {_STEPS[-2]} steps per period for the friction "
        "table; allow a larger tolerance"
    )
