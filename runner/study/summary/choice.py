"""The value of a key for which a quantile of an output is least."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.runner.study.study_file import Choose


@dataclass(frozen=True, eq=False)
class Choice:
    """A quantile of an output against a key.

    Attributes
    ----------
    of : Choose
    values : (n,) ndarray
        Of the key; strings where some are no numbers.
    quantile, failed : (n,) ndarray
        Of the output over the samples with each value, NaN where one of them failed; and how
        many did.
    unit : str
        Of the output.
    """

    of: Choose
    values: np.ndarray
    quantile: Floats
    failed: np.ndarray
    unit: str

    __repr__ = short_repr

    @property
    def best(self) -> int:
        """Place of the value for which the quantile is least."""
        return int(np.nanargmin(self.quantile))

    def text(self) -> str:
        """In a line."""
        value, least = self.values[self.best], self.quantile[self.best]
        shown = f"{value:.4g}" if isinstance(value, float) else str(value)
        part = "highest" if self.of.quantile == 1.0 else f"{self.of.quantile:.0%} quantile"
        return f"best {self.of.key} = {shown}: {part} of {self.of.output} {least:.4g} {self.unit}"


def choice(dataset: Any, of: Choose) -> Choice:
    """The quantile for each value of the key.

    Raises
    ------
    SlipmodeError
        If no value is without failures.
    """
    kind, mode = of.output.rsplit("_", 1)
    output = dataset[kind].sel(mode=mode)
    size, column = output.values, dataset[of.key].values
    values, group = np.unique(column, return_inverse=True)
    quantile, failed = np.full(values.size, np.nan), np.zeros(values.size, dtype=int)
    for k in range(values.size):
        own = size[group == k]
        failed[k] = np.count_nonzero(np.isnan(own))
        if not failed[k]:
            quantile[k] = np.quantile(own, of.quantile)
    if np.isnan(quantile).all():
        raise SlipmodeError(
            f"choose: of each value of {of.key} some samples failed; `reason` of them says why"
        )
    return Choice(of, values, quantile, failed, output.attrs["units"])
