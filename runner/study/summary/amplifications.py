"""Amplification factors of the mistuned disks of a study, in lines."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np

from slipmode.rom import Amplification
from slipmode.runner.study.study_file import Distribution, Study

# Disks from which on an extreme value distribution is fitted: resamples of a few disks often hold
# one of them alone, to which no distribution fits.
_FEWEST = 20


def amplifications(dataset: Any, study: Study) -> list[str]:
    """Return the distribution of the factors for each set of values of the listed keys.

    The keys that draw the disks, `mistuning.seed` and those with distributions, are left out.
    """
    keys = [
        each.key
        for each in study.varied
        if each.key != "mistuning.seed" and not isinstance(each.values, Distribution)
    ]
    factor, peak = (dataset[each].sel(mode="A").values for each in ("amplification", "resonance"))
    disks = defaultdict(list)
    rows = zip(*(dataset[key].values.tolist() for key in keys), strict=True)
    for place, row in enumerate(rows if keys else [()] * factor.size):
        if np.isfinite(factor[place]):
            disks[row].append(place)
    lines = []
    for row, places in disks.items():
        tuned = float(peak[places[0]] / factor[places[0]])
        found = Amplification(np.sort(factor[places]), tuned, len(study.scene.mistuning))
        named = ", ".join(f"{key} = {value}" for key, value in zip(keys, row, strict=True))
        lines.append(f"{named}: {_words(found)}" if named else _words(found))
    return lines


def _words(found: Amplification) -> str:
    middle, low, high = found.quantile(0.95)
    parts = [
        f"amplification of {found.factor.size} disks: median {np.median(found.factor):.3f}, "
        f"95 % below {middle:.3f} ({low:.3f} to {high:.3f})"
    ]
    if found.factor.size >= _FEWEST:
        middle, low, high = found.extreme_quantile(0.999)
        fitted = "by an extreme value distribution"
        parts.append(f"99.9 % below {middle:.3f} ({low:.3f} to {high:.3f}) {fitted}")
    side = "above" if found.factor[-1] > found.whitehead else "below"
    bound = f"Whitehead's bound {found.whitehead:.3f} of linear disks"
    parts.append(f"largest {found.factor[-1]:.3f}, {side} {bound}")
    return "; ".join(parts)
