"""The value of a key for which a quantile of an output is least."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.study.study_file import Choose


@dataclass(frozen=True, eq=False)
class Choice:
    """A quantile of an output against a key."""

    of: Choose
    values: np.ndarray  # (n,): The values of the key; strings if some are no numbers
    # quantile, failed: (n,): The quantile over the samples with each value, NaN if one of them
    # failed; and the number of these
    quantile: Floats
    failed: np.ndarray

    __repr__ = short_repr

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
        return f"best {self.of.key} = {shown}: {part} of {output} {least:.4g} {unit}"


def choice(column: np.ndarray, output: Floats, of: Choose) -> Choice:
    """Return the quantile of an output (samples,) for each value of a key (samples,).

    Raises
    ------
    SlipmodeError
        If every value has a failed sample.
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
            f"choose: of each value of {of.key} some samples failed; `reason` of them says why"
        )
    return Choice(of, values, quantile, failed)
