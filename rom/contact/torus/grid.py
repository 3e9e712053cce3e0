"""How finely the torus is resolved: steps along it, and lines across."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from slipmode.rom.arrays import Floats

# By the number of modes. Just past the onset of rigid friction the error of a march falls like
# steps^-1.3, so that a table to 1e-4 takes 4096.
_MOST_STEPS = {1: 16384, 2: 2048}


@dataclass(frozen=True)
class Discretisation:
    """How finely the torus is resolved.

    Attributes
    ----------
    steps : int
        Time steps per period of mode A.
    lines : int
        Phase lines of mode B, a power of two; 1 for a one-mode model. Of elastic contacts the
        least number, see `closed_lines`.
    """

    steps: int
    lines: int


@lru_cache(maxsize=64)
def closed_lines(ratio: float, least: int, off: float, *, odd: bool) -> tuple[int, float]:
    """Phase lines that go over into each other in a period of mode A, and Omega_B / Omega_A then.

    Lines that drift against the grid leave harmonics moving by its error, and a search for the
    periodic motion cannot come nearer than that. With a multiple of 1 / lines for a ratio a
    period takes each line to where another one was. Of up to twice the least the fewest lines are
    taken whose multiple is off by no more than `off`, relatively, or else those of the closest.

    Where the motion is `odd`, half a period does so with both phases turned by pi, if lines and
    multiple are both odd or both even: other lines are taken for that if it is less work, and
    they are about as close.
    """
    counts = range(least, 2 * least + 1)

    def closest(multiples: dict[int, int]) -> tuple[int, float]:
        away = {count: abs(multiples[count] / count / ratio - 1.0) for count in counts}
        near = [count for count in counts if away[count] <= off]
        lines = near[0] if near else min(counts, key=away.__getitem__)
        return lines, multiples[lines] / lines

    whole = closest({count: round(ratio * count) for count in counts})
    if not odd:
        return whole
    half = closest({count: 2 * round(0.5 * (ratio - 1.0) * count) + count for count in counts})
    away = abs(half[1] / ratio - 1.0)
    close = away <= max(off, 2.0 * abs(whole[1] / ratio - 1.0))
    # half periods are worth their search if they save 40 % of the work
    return half if close and 0.6 * half[0] <= whole[0] else whole


def enough_lines(orders: Sequence[tuple[int, int]]) -> int:
    """Return a number of phase lines, a power of two, that distinguishes these harmonics."""
    highest = max(abs(m) for _, m in orders)
    return 1 if highest == 0 else 1 << (2 * highest).bit_length()


def step_counts(carrier: Floats, least: int) -> tuple[int, ...]:
    """Time steps per period of mode A to try, from `least`, each twice the one before.

    The first sees several in a period of mode B too: with fewer, slip would follow another path
    than the one along a phase line, and as steadily on twice as many.
    """
    # four steps in a period of either mode
    fewest = 4 * max(float(carrier.max() / carrier[0]), 1.0)
    while least < fewest:
        least *= 2
    most = max(_MOST_STEPS[carrier.size], 16 * least)
    return tuple(least << k for k in range((most // least).bit_length()))
