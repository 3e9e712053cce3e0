"""Statistics over the samples of a study: the best value of a key, and Sobol indices."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.short_repr import frozen
from slipmode.runner.study.design import unit_problem
from slipmode.runner.study.study_file import Choose


@frozen
class Choice:
    """A quantile of an output against a key."""

    of: Choose
    values: np.ndarray  # (n,): The values of the key; strings if some are no numbers
    # quantile, failed: (n,): The quantile over the samples with each value, NaN if one of them
    # failed; and the number of these
    quantile: Floats
    failed: np.ndarray

    @property
    def best(self) -> int:
        """Index of the value for which the quantile is least."""
        return int(np.nanargmin(self.quantile))

    def text(self, unit: str, where: str) -> str:
        """Return the best value in a line; `where` is the DOF of the output, in words."""
        value, least = self.values[self.best], self.quantile[self.best]
        shown = f"{value:.4g}" if isinstance(value, float) else str(value)
        part = "highest" if self.of.quantile == 1.0 else f"{self.of.quantile:.0%} quantile"
        output = f"{self.of.output}{where}"
        found = f"best {self.of.key} = {shown}: {part} of {output} {least:.4g} {unit}"
        at_end = self.best in (0, self.values.size - 1) and self.values.dtype.kind in "if"
        return f"{found}, at the end of the values given" if at_end else found


def choice(column: np.ndarray, output: Floats, of: Choose) -> Choice:
    """Return the quantile of an output (samples,) for each value of a key (samples,).

    Raises SlipmodeError if every value has a failed sample.
    """
    values, group = np.unique(column, return_inverse=True)
    quantile, failed = np.full(values.size, np.nan), np.zeros(values.size, dtype=int)
    for k in range(values.size):
        own = output[group == k]
        failed[k] = np.count_nonzero(np.isnan(own))
        if not failed[k]:
            quantile[k] = np.quantile(own, of.quantile)
    if np.isnan(quantile).all():
        raise SlipmodeError(
            f"choose: some samples failed for each value of {of.key}; see `reason` of the results"
        )
    return Choice(of, values, quantile, failed)


@frozen
class Sensitivity:
    """Sobol indices of an output: shares of its variance due to each key."""

    output: str
    keys: tuple[str, ...]
    # first, total: (keys,): Share of the variance due to each key alone, and with the others
    first: Floats
    total: Floats
    # first_error, total_error: (keys,): Half of their confidence intervals of 95 %
    first_error: Floats
    total_error: Floats

    def text(self) -> list[str]:
        """Return a line per key."""
        width = max(map(len, self.keys))
        first = zip(self.keys, self.first, self.first_error, strict=True)
        total = zip(self.total, self.total_error, strict=True)
        return [
            f"{self.output}: {key:{width}}  first {f:6.3f} +- {fe:.3f}  total {t:6.3f} +- {te:.3f}"
            for (key, f, fe), (t, te) in zip(first, total, strict=True)
        ]


def sensitivity(output: str, values: Floats, keys: tuple[str, ...], seed: int) -> Sensitivity:
    """Return the indices of samples of the method "saltelli".

    Raises SlipmodeError if a sample failed: the method needs all of them.
    """
    failed = int(np.count_nonzero(np.isnan(values)))
    if failed:
        raise SlipmodeError(
            f"{output}: has no sensitivities, because {failed} samples failed; see `reason` of "
            "the results"
        )
    analyze: Any = extra("SALib.analyze.sobol", "study").analyze
    found = analyze(unit_problem(len(keys)), values, calc_second_order=False, seed=seed)
    return Sensitivity(output, keys, found["S1"], found["ST"], found["S1_conf"], found["ST_conf"])
