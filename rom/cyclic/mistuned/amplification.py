"""Statistics of amplification factors of disks whose blades differ."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, frozen, in_one_line

_RESAMPLES = 200  # of a bootstrap


@frozen
class Amplification:
    """Hold amplification factors: peaks of mistuned disks relative to the tuned disk.

    Attributes
    ----------
    factor : (patterns,) ndarray
        Largest amplitude of any blade at any frequency, relative to the tuned disk [-], ascending.
    tuned : float
        Peak of the tuned disk [m].
    sectors : int
        Number of blades N.
    """

    factor: Floats
    tuned: float
    sectors: int

    @property
    def whitehead(self) -> float:
        """Whitehead's bound (1 + sqrt(N)) / 2 of the factor of linear disks [-].

        Whitehead, D. S., Effect of mistuning on the vibration of turbomachine blades induced by
        wakes, Journal of Mechanical Engineering Science 8 (1966).
        """
        return 0.5 * (1.0 + float(np.sqrt(self.sectors)))

    def quantile(self, probability: float, confidence: float = 0.95) -> Floats:
        """Return a quantile of the factor with its confidence interval.

        The interval follows from order statistics and is valid for any distribution.

        Parameters
        ----------
        probability : float
            Probability that the factor is below the quantile [-], 0 to 1.
        confidence : float, default 0.95
            Probability of the interval [-].

        Returns
        -------
        (3,) ndarray
            Quantile, lower limit and upper limit [-]. With too few disks a limit is 0 or infinite.
        """
        _check_probabilities(probability, confidence)
        n, tail = self.factor.size, 0.5 * (1.0 - confidence)
        # The k-th factor is below the quantile if at least k of n disks are.
        low, high = (
            int(scipy.stats.binom.ppf(each, n, probability)) for each in (tail, 1.0 - tail)
        )
        padded = np.concatenate(([0.0], self.factor, [np.inf]))
        middle = float(np.quantile(self.factor, probability))
        return np.array([middle, padded[low], padded[high + 1]])

    def distribution(self, confidence: float = 0.95) -> Floats:
        """Return the probability that the factor of a disk is below each value of `factor`.

        Parameters
        ----------
        confidence : float, default 0.95
            Probability of the interval for each value separately [-].

        Returns
        -------
        (3, patterns) ndarray
            Estimates i / (n + 1) for the i-th of n disks, lower limits and upper limits [-].
        """
        _check_probabilities(0.5, confidence)
        n, tail = self.factor.size, 0.5 * (1.0 - confidence)
        rank = np.arange(1, n + 1)
        limits = [scipy.stats.beta.ppf(each, rank, n + 1 - rank) for each in (tail, 1.0 - tail)]
        return np.array([rank / (n + 1), *limits])

    @cached_property
    def extreme_value(self) -> Any:
        """Generalised extreme value distribution fitted to the factors (scipy.stats.genextreme).

        With c > 0 it is a Weibull distribution with three parameters, bounded by loc + scale / c.
        SlipmodeError if there are fewer than three factors, or all are equal.
        """
        if self.factor.size < 3 or np.ptp(self.factor) == 0.0:
            raise SlipmodeError(
                "factor: an extreme value distribution needs at least 3 factors that are not all "
                f"equal, got {in_one_line(self.factor)}"
            )
        return scipy.stats.genextreme(*_fitted(self.factor))

    def extreme_quantile(
        self, probability: float, confidence: float = 0.95, *, seed: int = 0
    ) -> Floats:
        """Return a quantile of `extreme_value` with its confidence interval.

        The quantile may lie beyond the factors of all disks.

        Parameters
        ----------
        probability : float
            Probability that the factor is below the quantile [-], 0 to 1.
        confidence : float, default 0.95
            Probability of the bootstrap interval, from fits to resampled disks [-].
        seed : int, default 0
            Seed of the resampling.

        Returns
        -------
        (3,) ndarray
            Quantile, lower limit and upper limit [-].

        Raises
        ------
        SlipmodeError
            If there are fewer than three factors, or all are equal.
        """
        _check_probabilities(probability, confidence)
        middle = self.extreme_value.ppf(probability)
        rng, n, tail = np.random.default_rng(seed), self.factor.size, 0.5 * (1.0 - confidence)
        drawn = [rng.choice(self.factor, n) for _ in range(_RESAMPLES)]
        # Few disks may be drawn all equal, which determines no distribution.
        fits = [_fitted(each) for each in drawn if np.ptp(each) > 0.0]
        again = scipy.stats.genextreme.ppf(probability, *np.transpose(fits))
        return np.array([middle, *np.quantile(again, [tail, 1.0 - tail])])


def _fitted(factor: Floats) -> tuple[float, float, float]:
    """Return c, loc and scale of the extreme value distribution with the same L-moments [1]_.

    .. [1] J. R. M. Hosking, L-moments: analysis and estimation of distributions using linear
       combinations of order statistics, Journal of the Royal Statistical Society B 52 (1990).
    """
    n = factor.size
    rank, ordered = np.arange(n), np.sort(factor)
    b_0 = ordered.mean()
    b_1 = np.sum(rank * ordered) / (n * (n - 1))
    b_2 = np.sum(rank * (rank - 1) * ordered) / (n * (n - 1) * (n - 2))
    second, third = 2.0 * b_1 - b_0, 6.0 * b_2 - 6.0 * b_1 + b_0
    # Hosking's approximation of the shape, within 9e-4
    x = 2.0 / (3.0 + third / second) - np.log(2.0) / np.log(3.0)
    c = 7.8590 * x + 2.9554 * x**2
    scale = second * c / ((1.0 - 2.0**-c) * scipy.special.gamma(1.0 + c))
    return float(c), float(b_0 - scale * (1.0 - scipy.special.gamma(1.0 + c)) / c), float(scale)


def _check_probabilities(probability: float, confidence: float) -> None:
    for name, value in (("probability", probability), ("confidence", confidence)):
        if not 0.0 < value < 1.0:
            raise SlipmodeError(f"{name}: must be between 0 and 1, got {value}")
