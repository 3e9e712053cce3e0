"""Uncertainty of parameters from the sum of squares around its minimum.

Residuals r(x) are independent with a deviation of 1, x the logarithms of the parameters. Among
them are (x - initial x) / PRIOR: initial values count as known to a factor of 10. Near the minimum
the covariance of x is (J^T J)^-1, Laplace's approximation. Where a parameter is known to some per
cent only, r is not linear over its interval. The interval follows from its profile then: the least
sum of squares with this parameter given.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipmode.rom.common import Flags, Floats, frozen

# Half-width of the 95 % interval of a logarithm from which a parameter is not identified
OPEN = np.log(2.0)
PRIOR = np.log(10.0)  # deviation of the logarithms of initial values
LINEAR = 0.1  # half-widths up to which Laplace's approximation is used


@frozen
class Minimum:
    """Unknowns with the least sum of squares."""

    x: Floats
    cost: float  # half the sum of squares


Fit = Callable[[Floats, Flags], Minimum]  # least squares from given unknowns, some of them fixed


@frozen
class Posterior:
    """Logarithms of parameters and their uncertainty.

    Attributes
    ----------
    names : tuple of str
    logarithms : (names,) ndarray
    covariance : (names, names) ndarray
        By Laplace's approximation.
    interval : (2, names) ndarray
        Ends of 95 % intervals of the logarithms.
    quantile : float
        Half-width of 95 % intervals relative to deviations.
    """

    names: tuple[str, ...]
    logarithms: Floats
    covariance: Floats
    interval: Floats
    quantile: float

    @property
    def is_open(self) -> Flags:
        """Which parameters are not identified, (names,)."""
        return np.asarray(self.interval[1] - self.interval[0] > 2.0 * OPEN)

    def combinations(self) -> tuple[dict[str, tuple[float, float]], tuple[str, ...]]:
        """Return products of powers of parameters that are open by Laplace's approximation.

        Returns
        -------
        determined : dict
            95 % interval (low, high) of each product that the data determine.
        undetermined : tuple of str
            Products that they do not determine.
        """
        deviation = np.sqrt(np.diag(self.covariance))
        (at,) = np.nonzero(self.quantile * deviation > OPEN)
        names = [self.names[k] for k in at]
        covariance = self.covariance[np.ix_(at, at)]
        determined, undetermined = {}, []
        for vector in np.linalg.eigh(covariance)[1].T:
            exponents = np.round(vector / vector[np.argmax(np.abs(vector))], 2)
            half = self.quantile * np.sqrt(exponents @ covariance @ exponents)
            words = _product(names, exponents)
            if half > OPEN:
                undetermined.append(words)
            else:
                middle = exponents @ self.logarithms[at]
                low, high = np.exp([middle - half, middle + half]).tolist()
                determined[words] = low, high
        return determined, tuple(undetermined)


def profile_end(
    fit: Fit, optimum: Minimum, slope: Floats, k: int, step: float, rise: float
) -> float:
    """Return unknown k where its profile has risen.

    Parameters
    ----------
    fit : callable
    optimum : Minimum
    slope : (names,) ndarray
        Change of all unknowns with unknown k at the optimum.
    k : int
    step : float
        First step of unknown k.
    rise : float
        Rise of the sum of squares.
    """
    last, root = optimum.x, 0.0
    while True:
        found = fit(last + step * slope, np.arange(last.size) == k)
        moved = found.x[k] - last[k]
        if moved == 0.0:  # at a bound
            return float(last[k])
        next_root = np.sqrt(max(2.0 * (found.cost - optimum.cost), 0.0))
        if next_root >= np.sqrt(rise):
            return float(last[k] + moved * (np.sqrt(rise) - root) / (next_root - root))
        slope = (found.x - last) / moved
        last, root, step = found.x, next_root, 1.5 * step


def _product(names: Sequence[str], exponents: Floats) -> str:
    """Return a product of powers in words."""
    words = []
    for name, exponent in zip(names, exponents, strict=True):
        base = f"(1 + {name})" if name.endswith(".chi") else name
        if exponent != 0.0:
            words.append(base if exponent == 1.0 else f"{base}^{exponent:g}")
    return " * ".join(words)
