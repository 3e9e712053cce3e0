"""Patterns of mistuning: random ones, and from measured frequencies of blades."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, as_floats, in_one_line
from slipmode.rom.cyclic.structure import checked_integer


def random_mistuning(
    patterns: int, sectors: int, deviation: float, *, seed: int = 0, uniform: bool = False
) -> Floats:
    """Return independent random stiffness deviations of blades.

    Parameters
    ----------
    patterns : int
        Number of mistuning patterns.
    sectors : int
        Number of blades N.
    deviation : float
        Standard deviation of the relative stiffness [-], at most 0.2. It is about twice the
        standard deviation of the blade frequencies.
    seed : int, default 0
        Seed of the random numbers. Equal seeds give equal patterns.
    uniform : bool, default False
        Use a uniform distribution instead of a normal one.

    Returns
    -------
    (patterns, sectors) ndarray
        Relative stiffness deviations [-].

    Raises
    ------
    SlipmodeError
        If a number is outside its range.

    Examples
    --------
    >>> rom.random_mistuning(100, 24, 0.04).shape
    (100, 24)
    """
    checked_integer("patterns", patterns, ">= 1", 1)
    checked_integer("sectors", sectors, ">= 1", 1)
    if not 0.0 < deviation <= 0.2:
        raise SlipmodeError(f"deviation: must be above 0 and at most 0.2, got {deviation}")
    rng = np.random.default_rng(seed)
    shape = (patterns, sectors)
    if uniform:
        return np.asarray(np.sqrt(3.0) * deviation * rng.uniform(-1.0, 1.0, shape))
    return np.asarray(deviation * rng.standard_normal(shape))


def stiffness_deviation(frequency: ArrayLike, nominal: float | None = None) -> Floats:
    """Return the relative stiffness deviations (f / f_0)^2 - 1 of blades from their frequencies.

    The frequencies are measured on single blades, clamped at their roots. The deviations apply to
    the complete stiffness of a blade, which `CyclicStructure.blade` must contain.

    Parameters
    ----------
    frequency : (N,) or (patterns, N) array_like
        Blade frequencies f > 0, in any unit.
    nominal : float, optional
        Frequency f_0 of the tuned blade, in the unit of `frequency`. Default: the mean.

    Returns
    -------
    (N,) or (patterns, N) ndarray
        Relative stiffness deviations [-].

    Raises
    ------
    SlipmodeError
        If a frequency is not positive or not finite.

    Examples
    --------
    >>> rom.stiffness_deviation([200.0, 202.0, 198.0]).round(4)
    array([ 0.    ,  0.0201, -0.0199])
    """
    given = as_floats("frequency", frequency)
    if given.size == 0 or not np.all((given > 0.0) & np.isfinite(given)):
        raise SlipmodeError(f"frequency: must be finite numbers > 0, got {in_one_line(frequency)}")
    reference = float(given.mean()) if nominal is None else float(nominal)
    if not (np.isfinite(reference) and reference > 0.0):
        raise SlipmodeError(f"nominal: must be a finite number > 0, got {nominal}")
    return np.asarray((given / reference) ** 2 - 1.0)
