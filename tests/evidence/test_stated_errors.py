"""No true error above the stated one, on drawn structures; `make bench-errors` measures more."""

from importlib.util import find_spec

import pytest

from evidence.answers import MODE_SLIDERS, equilibrium, near, variant
from evidence.kinds import KINDS

pytestmark = pytest.mark.oracle

# Structures of each kind: quick ones, then the ones of `make test-all`.
QUICK = {
    "direct": (0, 13),
    "near": (0, 1),
    "table": (5,),
    "curve": (5,),
    "backbone": (0, 4),
    "sweep": (1, 3),
    "rest": (0, 1, 2),
    "wave": (0, 1, 5),
    **dict.fromkeys(("fmu", "force", "mistuned", "identified"), (1,)),
}
SLOW = {
    "direct": (1, 4, 7, 10, 15, 27, 42, 50),
    "near": tuple(range(2, 15)),
    "close": (0, 3, 4, 7, 8),
    "internal": (0, 1, 2, 3, 4, 5),
    "curve": (2, 3, 6, 7, 21),
    "backbone": (10, *range(12, 29)),
    "sweep": (0, 2, 4, 5, 6, 16, 17),
    "rest": (3,),
    "wave": (4, 6),
    **dict.fromkeys(("fmu", "force", "mistuned", "identified"), (2,)),
}
# Cases that fall short today, with their figures.
SHORT = {
    ("rest", 0): "RMS error 2.9 % from rest, allowed 1 % and no warning",
    ("curve", 7): "refused, or not, by rounding: 3 Omega is 0.1 % from a mode, at |a| = 0.64",
}


def _cases():
    for seeds_of, marks in ((QUICK, []), (SLOW, [pytest.mark.slow])):
        for kind, seeds in seeds_of.items():
            for seed in seeds:
                own = list(marks)
                if (kind, seed) in SHORT:
                    own.append(pytest.mark.xfail(strict=True, reason=SHORT[kind, seed]))
                if kind == "fmu":
                    own.append(pytest.mark.skipif(not find_spec("fmpy"), reason="without FMPy"))
                yield pytest.param(kind, seed, id=f"{kind}-{seed}", marks=own)


@pytest.mark.parametrize(("kind", "seed"), list(_cases()))
def test_true_errors_are_below_the_stated_ones(kind, seed):
    answer, drawn = KINDS[kind]
    answers = answer(drawn(seed))
    assert answers
    assert not [each for each in answers if each.violated]


@pytest.mark.parametrize("seed", range(6))
def test_steady_states_satisfy_the_equations_of_motion(seed):
    assert not equilibrium(near(seed)).violated
    assert not equilibrium(variant(4 * seed, MODE_SLIDERS, 1)).violated
