"""The kinds of answers that are measured, and the case of a seed for each."""

from collections.abc import Callable

from oracles.families import Case, case

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
from evidence.sweeps import sweep

KINDS: dict[str, tuple[Callable[[Case], list[Answer]], Callable[[int], Case]]] = {
    "direct": (direct, variant),
    "near": (direct, near),
    "table": (table, variant),
    "close": (table, lambda seed: case(seed, 2, MODE_SLIDERS, 1.05)),
    "internal": (table, lambda seed: case(seed, 2, MODE_SLIDERS, (3.01, 2.98, 2.01)[seed % 3])),
    "curve": (curve, lambda seed: variant(seed, modes=1)),
    "backbone": (backbone, lambda seed: variant(seed, MODE_SLIDERS, 1)),
    "sweep": (sweep, lambda seed: variant(seed, MODE_SLIDERS, 1)),
}
