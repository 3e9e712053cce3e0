"""The values of every sample, in an order that keeps samples of one model together."""

from __future__ import annotations

import warnings
from math import prod
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.extras import extra
from slipmode.rom.short_repr import frozen
from slipmode.runner.study.scene_keys import is_limit, is_load
from slipmode.runner.study.study_file import Distribution, Sampling, Study


@frozen
class Design:
    """Samples, numbered from 0."""

    keys: tuple[str, ...]  # The keys that vary, in the order of the study
    # The value of each key; arrays of objects if some values are no numbers
    columns: tuple[NDArray[Any], ...]

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.columns[0])

    def part(self, samples: slice | NDArray[np.intp]) -> Design:
        """Return the design of some samples only."""
        return Design(self.keys, tuple(column[samples] for column in self.columns))

    def rows(self) -> list[tuple[Any, ...]]:
        """Return the values of each sample, as TOML has them."""
        return list(zip(*(column.tolist() for column in self.columns), strict=True))


def make_design(study: Study) -> Design:
    """Return all samples of a study.

    Listed values are crossed with each other and with the draws from the distributions. Keys of
    loads and limits run fastest, so that samples of one model follow each other.
    """
    distributions: dict[str, Distribution] = {}
    listed: dict[str, NDArray[Any]] = {}
    for each in study.varied:
        if isinstance(each.values, Distribution):
            distributions[each.key] = each.values
        else:
            listed[each.key] = _column(each.values)
    keys = tuple(each.key for each in study.varied)
    if study.sampling.method == "list":
        return Design(keys, tuple(listed[key] for key in keys))
    slow = [key for key in listed if not (is_load(key) or is_limit(key))]
    fast = [key for key in listed if key not in slow]
    draws = _draws(list(distributions.values()), study.sampling)
    shape = [*(listed[key].size for key in slow), len(draws), *(listed[key].size for key in fast)]
    places = np.unravel_index(np.arange(prod(shape)), shape)
    place = dict(zip([*slow, "draw", *fast], places, strict=True))
    columns = {key: column[place[key]] for key, column in listed.items()}
    columns |= {key: draws[place["draw"], k] for k, key in enumerate(distributions)}
    return Design(keys, tuple(columns[key] for key in keys))


def _column(values: tuple[Any, ...]) -> NDArray[Any]:
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        column = np.array(values)
        if column.dtype.kind in "if":
            return column
    column = np.empty(len(values), dtype=object)
    column[:] = values  # lists stay lists
    return column


def _draws(distributions: list[Distribution], sampling: Sampling) -> Floats:
    """Return values of keys with distributions, (draws, keys)."""
    if not distributions:
        return np.zeros((1, 0))
    # the quantiles of 0 and 1 may be infinite
    part = np.clip(_unit_cube(len(distributions), sampling), 1e-12, 1.0 - 1e-12)
    return np.column_stack([each.quantile(part[:, k]) for k, each in enumerate(distributions)])


def _unit_cube(keys: int, sampling: Sampling) -> Floats:

    samples, seed = sampling.samples, sampling.seed
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that numbers other than powers of 2 are not balanced
        if sampling.method == "saltelli":
            sample = extra("SALib.sample.sobol", "study").sample
            parts = sample(unit_problem(keys), samples, calc_second_order=False, seed=seed)
        elif sampling.method == "latin-hypercube":
            parts = scipy.stats.qmc.LatinHypercube(keys, rng=seed).random(samples)
        else:
            parts = scipy.stats.qmc.Sobol(keys, rng=seed).random(samples)
    return np.asarray(parts, dtype=float)


def unit_problem(keys: int) -> dict[str, Any]:
    """Return SALib's description of uniform parts of any distributions."""
    names = [str(k) for k in range(keys)]
    return {"num_vars": keys, "names": names, "bounds": [[0.0, 1.0]] * keys}
