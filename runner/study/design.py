"""The values of every sample, in an order in which those that may share a model are together."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.extras import extra
from slipmode.rom.short_repr import short_repr
from slipmode.runner.study.scene_keys import is_load
from slipmode.runner.study.shared_limits import is_limit
from slipmode.runner.study.study_file import Distribution, Sampling, Study, Varied

_SMALLEST = 1e-12  # part of a distribution left out at both ends: normal ones have no end


@dataclass(frozen=True, eq=False)
class Design:
    """Samples, numbered from 0.

    Attributes
    ----------
    keys : tuple of str
        That vary, in the order of the study.
    columns : tuple of (samples,) ndarray
        The value of each key; of objects where some are no numbers.
    """

    keys: tuple[str, ...]
    columns: tuple[NDArray[Any], ...]

    __repr__ = short_repr

    @property
    def samples(self) -> int:
        """How many there are."""
        return len(self.columns[0])

    def rows(self, samples: slice) -> list[tuple[Any, ...]]:
        """Values of some samples, as TOML has them."""
        return list(zip(*(column[samples].tolist() for column in self.columns), strict=True))


def make_design(study: Study) -> Design:
    """All samples of a study.

    Values are crossed with each other and with what is drawn of the distributions. Keys of the
    loads run fastest, so that samples of one model follow each other.
    """
    keys = tuple(each.key for each in study.varied)
    drawn = [each for each in study.varied if isinstance(each.values, Distribution)]
    listed = [each for each in study.varied if not isinstance(each.values, Distribution)]
    if study.sampling.method == "list":
        return Design(keys, tuple(_column(each) for each in listed))
    slow = [each for each in listed if not (is_load(each.key) or is_limit(each.key))]
    fast = [each for each in listed if each not in slow]
    draws = _drawn(drawn, study.sampling) if drawn else np.zeros((1, 0))
    shape = [len(each.values) for each in slow] + [len(draws)]  # type: ignore[arg-type]
    shape += [len(each.values) for each in fast]  # type: ignore[arg-type]
    number = np.arange(prod(shape))
    place = dict(zip([*slow, "draw", *fast], np.unravel_index(number, shape), strict=True))
    columns = {each.key: _column(each)[place[each]] for each in listed}
    columns |= {each.key: draws[place["draw"], k] for k, each in enumerate(drawn)}
    return Design(keys, tuple(columns[key] for key in keys))


def _column(varied: Varied) -> NDArray[Any]:
    values = varied.values
    assert not isinstance(values, Distribution)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        column = np.array(values)
        if column.dtype.kind in "if":
            return column
    column = np.empty(len(values), dtype=object)
    column[:] = values  # lists stay values
    return column


def _drawn(varied: list[Varied], sampling: Sampling) -> Floats:
    """Values of keys with distributions, (draws, keys)."""
    part = np.clip(_unit_cube(len(varied), sampling), _SMALLEST, 1.0 - _SMALLEST)
    columns = []
    for k, each in enumerate(varied):
        assert isinstance(each.values, Distribution)
        columns.append(each.values.quantile(part[:, k]))
    return np.column_stack(columns)


def _unit_cube(keys: int, sampling: Sampling) -> Floats:
    from scipy.stats import qmc

    if sampling.method == "saltelli":
        sample = extra("SALib.sample.sobol", "study").sample
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # balance, as below
            unit = sample(
                unit_problem(keys), sampling.samples, calc_second_order=False, seed=sampling.seed
            )
        return np.asarray(unit, dtype=float)
    if sampling.method == "latin-hypercube":
        drawn = qmc.LatinHypercube(keys, rng=sampling.seed).random(sampling.samples)
    else:
        with warnings.catch_warnings():  # balance wants powers of 2; any number may be asked for
            warnings.simplefilter("ignore", UserWarning)
            drawn = qmc.Sobol(keys, rng=sampling.seed).random(sampling.samples)
    return np.asarray(drawn, dtype=float)


def unit_problem(keys: int) -> dict[str, Any]:
    """What SALib calls the problem: parts of distributions, so that any may be behind them."""
    return {
        "num_vars": keys,
        "names": [str(k) for k in range(keys)],
        "bounds": [[0.0, 1.0]] * keys,
    }
