"""Sobol indices: the share of an output's variance due to each key, alone and with others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.short_repr import short_repr
from slipmode.runner.study.design import unit_problem


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Indices of an output."""

    output: str
    keys: tuple[str, ...]
    # first, total: (keys,): Share of the variance due to each key alone, and with the others
    first: Floats
    total: Floats
    # first_error, total_error: (keys,): Half of their confidence intervals of 95 %
    first_error: Floats
    total_error: Floats

    __repr__ = short_repr

    def text(self) -> list[str]:
        """Return a line per key."""
        width = max(map(len, self.keys))
        rows = zip(
            self.keys, self.first, self.first_error, self.total, self.total_error, strict=True
        )
        return [
            f"{self.output}: {key:{width}}  first {f:6.3f} +- {fe:.3f}  total {t:6.3f} +- {te:.3f}"
            for key, f, fe, t, te in rows
        ]


def sensitivity(output: str, values: Floats, keys: tuple[str, ...], seed: int) -> Sensitivity:
    """Return the indices of samples that were drawn by the method "saltelli".

    Raises
    ------
    SlipmodeError
        If a sample failed: the method needs all of them.
    """
    failed = int(np.count_nonzero(np.isnan(values)))
    if failed:
        raise SlipmodeError(
            f"{output}: no sensitivities, for {failed} samples failed; `reason` of them says why"
        )
    analyze: Any = extra("SALib.analyze.sobol", "study").analyze
    found = analyze(unit_problem(len(keys)), values, calc_second_order=False, seed=seed)
    return Sensitivity(output, keys, found["S1"], found["ST"], found["S1_conf"], found["ST_conf"])
