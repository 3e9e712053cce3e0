"""Patterns of mistuning: random ones, and from measured frequencies of blades."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError


def random_mistuning(
    patterns: int, sectors: int, deviation: float, *, seed: int = 0, uniform: bool = False
) -> Floats:
    """Return independent random stiffness deviations of blades, (patterns, sectors).

    Parameters
    ----------
    patterns, sectors : int
    deviation : float
        Standard deviation of the relative stiffness; about twice that of the frequencies.
    seed : int
        Equal seeds draw equal patterns.
    uniform : bool
        Uniform instead of normal distribution.

    Examples
    --------
    >>> random_mistuning(100, 24, 0.04).shape
    (100, 24)
    """
    for name, count in (("patterns", patterns), ("sectors", sectors)):
        if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
            raise SlipmodeError(f"{name}: must be an integer >= 1, got {in_one_line(count)}")
    if not 0.0 < deviation <= 0.2:
        raise SlipmodeError(f"deviation: must be above 0 and at most 0.2, got {deviation}")
    rng = np.random.default_rng(seed)
    shape = (patterns, sectors)
    if uniform:
        return np.asarray(np.sqrt(3.0) * deviation * rng.uniform(-1.0, 1.0, shape))
    return np.asarray(deviation * rng.standard_normal(shape))


def stiffness_deviation(frequency: ArrayLike, nominal: float | None = None) -> Floats:
    """Return the stiffness deviations of blades from their frequencies, (f / f_0)^2 - 1.

    The frequencies are those of single blades, clamped at their roots. They belong to
    deviations of the whole stiffness of a blade, which `CyclicStructure.blade` must contain.

    Parameters
    ----------
    frequency : (N,) or (patterns, N) array_like
        In any unit, > 0.
    nominal : float, optional
        f_0 of the tuned blade, in the same unit. Default: the mean of the frequencies.

    Examples
    --------
    >>> stiffness_deviation([200.0, 202.0, 198.0]).round(4)
    array([ 0.    ,  0.0201, -0.0199])
    """
    given = as_floats("frequency", frequency)
    if given.size == 0 or not np.all((given > 0.0) & np.isfinite(given)):
        raise SlipmodeError(f"frequency: must be finite numbers > 0, got {in_one_line(frequency)}")
    reference = float(given.mean()) if nominal is None else float(nominal)
    if not (np.isfinite(reference) and reference > 0.0):
        raise SlipmodeError(f"nominal: must be a finite number > 0, got {nominal}")
    return np.asarray((given / reference) ** 2 - 1.0)
