"""The kinds of answers that are measured, and the case of a seed for each."""

from collections.abc import Callable
from typing import Any

from oracles.families import case

from evidence.answers import (
    MODE_SLIDERS,
    Answer,
    backbone,
    curve,
    direct,
    near,
    table,
    variant,
)
from evidence.decays import identified
from evidence.disks import disk, mistuned, wave
from evidence.runs import contact_force, fmu, rest, sweep


def _sliders(seed: int):
    return variant(seed, MODE_SLIDERS, 1)


KINDS: dict[str, tuple[Callable[[Any], list[Answer]], Callable[[int], Any]]] = {
    "direct": (direct, variant),
    "near": (direct, near),
    "table": (table, variant),
    "close": (table, lambda seed: case(seed, 2, MODE_SLIDERS, 1.05)),
    "internal": (table, lambda seed: case(seed, 2, MODE_SLIDERS, (3.01, 2.98, 2.01)[seed % 3])),
    "curve": (curve, lambda seed: variant(seed, modes=1)),
    "backbone": (backbone, _sliders),
    "sweep": (sweep, _sliders),
    "rest": (rest, _sliders),
    "fmu": (fmu, _sliders),
    "force": (contact_force, _sliders),
    "wave": (wave, disk),
    "mistuned": (mistuned, disk),
    "identified": (identified, _sliders),
}
