"""No true error above the stated one, on drawn structures; `make bench-errors` measures more."""

import pytest

from evidence.answers import MODE_SLIDERS, equilibrium, near, variant
from evidence.kinds import KINDS

# Structures of each kind: quick ones, then those of `make test-all`.
QUICK = {
    "direct": (0, 10, 13),
    "near": (0, 1, 2),
    "table": (5, 7),
    "curve": (5, 6),
    "backbone": (0, 4, 10),
}
SLOW = {
    "direct": (1, 7, 9, 14, 15),
    "near": tuple(range(3, 15)),
    "table": (2,),
    "curve": (2, 7),
    "backbone": tuple(range(12, 30)),
}


def _selected():
    for kind, seeds in QUICK.items():
        yield from (pytest.param(kind, seed, id=f"{kind}-{seed}") for seed in seeds)
    for kind, seeds in SLOW.items():
        yield from (
            pytest.param(kind, seed, id=f"{kind}-{seed}", marks=pytest.mark.slow) for seed in seeds
        )


@pytest.mark.parametrize(("kind", "seed"), list(_selected()))
def test_true_errors_are_below_the_stated_ones(kind, seed):
    answer, drawn = KINDS[kind]
    answers = answer(drawn(seed))
    assert answers
    assert not [each for each in answers if each.violated]


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("near", seed) for seed in range(4)] + [("far", seed) for seed in range(0, 16, 4)],
)
def test_steady_states_satisfy_the_equations_of_motion(kind, seed):
    given = near(seed) if kind == "near" else variant(seed, MODE_SLIDERS, 1)
    assert not equilibrium(given).violated
