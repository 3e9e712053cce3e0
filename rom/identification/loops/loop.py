"""Measured loops of force against displacement, their strokes and cycles."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Self

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, as_floats, frozen, in_one_line

# Reversals smaller than this share of the range of the displacement are noise.
REVERSAL = 0.02
RUN_IN = 2  # strokes that settle the contacts
FEWEST_CYCLES = 2  # with these
# Share of a cycle by which the path of the displacement may be shorter.
SHORTER = 0.1


@frozen
class Loop:
    """Hold measured cycles of one joint: force against displacement, in the order of time.

    Attributes
    ----------
    name : str
        Name, unique among loops.
    displacement : (samples,) ndarray
        Relative displacement [m].
    force : (samples,) ndarray
        Force that moves the joint [N]. It is positive if it pulls towards larger displacements.
    notes : tuple of str
        What was found when the loop was read, one line each.
    """

    name: str
    displacement: Floats
    force: Floats
    notes: tuple[str, ...] = ()


@frozen
class Strokes:
    """The strokes of a loop between its turning points.

    Attributes
    ----------
    name : str
        Name of the loop.
    displacement, force : sequence of (samples,) ndarray
        Samples of each stroke [m], [N].
    """

    name: str
    displacement: Sequence[Floats]
    force: Sequence[Floats]

    @classmethod
    def of(cls, loop: Any) -> Self:
        """Return the strokes of a loop, checked."""
        if not isinstance(loop, Loop):
            raise SlipmodeError(f"loops: must be of rom.Loop, got {in_one_line(loop)}")
        x, force = (
            as_floats(f"{loop.name}.{name}", getattr(loop, name))
            for name in ("displacement", "force")
        )
        if x.ndim != 1 or x.shape != force.shape:
            raise SlipmodeError(
                f"loops: {loop.name} must have as many forces as displacements, got shapes "
                f"{force.shape} and {x.shape}"
            )
        if not (np.isfinite(x).all() and np.isfinite(force).all()):
            raise SlipmodeError(f"loops: {loop.name} has samples that are no finite numbers")
        ends = turning_points(x) if x.size and np.ptp(x) > 0.0 else []
        parts = [slice(a, b + 1) for a, b in pairwise(ends)]
        strokes = cls(loop.name, [x[part] for part in parts], [force[part] for part in parts])
        path = float(np.abs(np.diff(x[ends])).sum()) if ends else 0.0
        cycles = path / (2.0 * np.ptp(x)) if ends else 0.0
        if strokes.cycles < 1 or cycles < FEWEST_CYCLES - SHORTER:
            raise SlipmodeError(
                f"loops: {loop.name} must have at least {FEWEST_CYCLES} cycles, of which the "
                f"first one settles the contacts, got {cycles:.2g}"
            )
        if strokes.work() <= 0.0:
            raise SlipmodeError(
                f"loops: {loop.name} dissipates no energy: the work is {strokes.work():.3g} J per "
                "cycle; reverse the sign of force or displacement if they are opposite"
            )
        return strokes

    @property
    def cycles(self) -> int:
        """Number of complete cycles after the run-in."""
        return (len(self.force) - RUN_IN) // 2

    @property
    def used_force(self) -> Floats:
        """Forces of the strokes after the run-in [N]."""
        return np.concatenate(self.force[RUN_IN:])

    @property
    def used_displacement(self) -> Floats:
        """Displacements of the strokes after the run-in [m]."""
        return np.concatenate(self.displacement[RUN_IN:])

    @property
    def peak(self) -> float:
        """Largest force after the run-in [N]."""
        return float(np.abs(self.used_force).max())

    @property
    def middle(self) -> float:
        """Middle of the displacements after the run-in [m]."""
        x = self.used_displacement
        return float(0.5 * (x.min() + x.max()))

    def work(self) -> float:
        """Return the mean work per cycle after the run-in [J]."""
        pairs = zip(self.displacement[RUN_IN:], self.force[RUN_IN:], strict=True)
        return float(np.mean([np.trapezoid(f, x) for x, f in pairs])) * 2.0

    def cycle_of_sample(self) -> Floats:
        """Return the cycle of each sample after the run-in, (samples,).

        A stroke without a second one belongs to the cycle before it.
        """
        sizes = [f.size for f in self.force[RUN_IN:]]
        cycles = np.minimum(np.arange(len(sizes)) // 2, self.cycles - 1)
        return np.repeat(cycles, sizes)

    def thinned(self, samples: int) -> Strokes:
        """Return strokes of about so many samples in all, with their turning points."""
        every = max(sum(f.size for f in self.force) // samples, 1)
        chosen = [
            np.unique(np.append(np.arange(0, f.size, every), f.size - 1)) for f in self.force
        ]
        x, force = (
            [values[rows] for values, rows in zip(given, chosen, strict=True)]
            for given in (self.displacement, self.force)
        )
        return Strokes(self.name, x, force)


def turning_points(x: Floats) -> list[int]:
    """Return the indices of the extrema of displacements (samples,), also the first and last."""
    values, threshold = x.tolist(), REVERSAL * float(np.ptp(x))
    points: list[int] = []
    low = high = direction = 0
    for i, value in enumerate(values):
        if value > values[high]:
            high = i
        if value < values[low]:
            low = i
        if direction >= 0 and values[high] - value > threshold:
            points.append(high)
            direction, low = -1, i
        elif direction <= 0 and value - values[low] > threshold:
            points.append(low)
            direction, high = 1, i
    return [*points, high if direction > 0 else low]
