"""The value of a key for which a quantile of an output is least."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.units import Shown
from slipmode.runner.study.study_file import Choose
from slipmode.runner.study.summary.shown import shown_output


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
    unit, where : str
        Of the output: its unit, and of which DOF it is.
    """

    of: Choose
    values: np.ndarray
    quantile: Floats
    failed: np.ndarray
    unit: str
    where: str

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
        output = f"{self.of.output}{self.where}"
        return f"best {self.of.key} = {shown}: {part} of {output} {least:.4g} {self.unit}"


def choice(dataset: Any, of: Choose, shown: Shown) -> Choice:
    """Return the quantile of the output, as it is shown, for each value of the key.

    Raises
    ------
    SlipmodeError
        If no value is without failures.
    """
    kind, mode = of.output.rsplit("_", 1)
    output = shown_output(dataset, kind, shown)
    size, column = output.values.sel(mode=mode).values, dataset[of.key].values
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
    return Choice(of, values, quantile, failed, output.unit, output.where)
