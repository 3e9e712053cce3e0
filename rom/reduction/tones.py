"""Several modes on a tone: which modes one force can drive together.

Modes near its frequency respond to the force itself. A mode near a multiple of it, or a fraction,
responds to a harmonic of the contacts (internal resonance), on a carrier of a fixed ratio.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import (
    CombinationResonance,
    combination_resonances,
    locked_resonances,
)
from slipmode.rom.short_repr import percentage

if TYPE_CHECKING:
    from slipmode.rom.reduction.reduced import Reduced

# Each amplitude acts on every other one through each contact. Beyond, harmonic balance of all
# degrees of freedom costs less.
_MOST_MODES = 40
# Relative distance of the frequencies of modes on one tone. A mode further away does not come into
# resonance with the force when friction changes its frequency, and responds as all other modes do.
FARTHEST = 0.15
# Relative distance of two frequencies that are the same: the beat takes a million periods.
_SAME = 1e-6
# Largest integer in a ratio of carriers: the harmonics of contacts that reach them end at 15.
LARGEST_INTEGER = 9


def shared_tones(tones: Sequence[int] | None, modes: int) -> tuple[int, ...]:
    """Return the tone of each mode if several modes share one, otherwise (); refuse others.

    Default of `tones`: mode j is on tone j.
    """
    if tones is None:
        return ()
    numbers = as_floats("tones", list(tones)).tolist()
    if numbers == list(range(modes)):
        return ()
    if len(numbers) != modes or not set(numbers) <= {0.0, 1.0}:
        raise SlipmodeError(
            f"tones: must be {modes} numbers, the tone 0 or 1 of each mode, got "
            f"{in_one_line(tones)}"
        )
    if numbers != sorted(numbers) or numbers[0]:
        raise SlipmodeError(
            f"tones: must have the modes of tone 0 first, then the modes of tone 1, got "
            f"{in_one_line(tones)}; change the order of modes"
        )
    most = max(numbers.count(tone) for tone in numbers)
    if most > _MOST_MODES:
        raise SlipmodeError(
            f"modes: at most {_MOST_MODES} modes share a tone, got {most}; retain modes near the "
            "forcing frequency, the others respond to it as well"
        )
    return tuple(int(tone) for tone in numbers)


def modes_of_tones(numbers: Sequence[int]) -> list[slice]:
    """Return the modes of each tone, of the tone of each mode (modes,)."""
    starts = [k for k, tone in enumerate(numbers) if not k or tone != numbers[k - 1]]
    return [slice(*ends) for ends in zip(starts, [*starts[1:], len(numbers)], strict=True)]


def names_on_tones(modes: Sequence[slice]) -> list[str]:
    """Return the names of the modes of each tone: A, A2, A3, ..., B, B2, ..."""
    return [
        name if not k else f"{name}{k + 1}"
        for name, own in zip("AB", modes, strict=False)
        for k in range(own.stop - own.start)
    ]


def sliding_law(law: Friction | None, contacts: int) -> Elastic:
    """Return a law whose contacts do not lift off; refuse any other."""
    if isinstance(law, Elastic) and law.elements(contacts).odd:
        return law
    raise SlipmodeError(
        "law: several modes on one tone need contacts that slide and do not lift off "
        f"(rom.Jenkins, Iwan or Sliders), got {in_one_line(law)}"
    )


def check_tones(reduced: Reduced, given: Mapping[str, object]) -> None:
    """Refuse modes that cannot share a tone, and arguments that are given."""
    for key, value in given.items():
        if value is not None:
            raise SlipmodeError(f"{key}: must be left out if several modes share a tone")
    for own in reduced.on_tones:
        frequency, modes = reduced.frequency[own], reduced.modes[own]
        low, high = int(frequency.argmin()), int(frequency.argmax())
        apart = float(frequency[high] / frequency[low] - 1.0)
        if apart > FARTHEST:
            raise SlipmodeError(
                f"tones: mode {modes[low]} at {frequency[low]:.5g} rad/s and mode {modes[high]} "
                f"at {frequency[high]:.5g} rad/s are {percentage(apart)} apart, and one tone "
                f"resonates with modes within {percentage(FARTHEST)}; leave one of them out, it "
                "still responds to the force, or use a tone for each, tones=(0, 1)"
            )


def check_two_carriers(frequency: Floats) -> None:
    """Refuse frequencies (points, 2) [rad/s] where a harmonic of one tone is the other tone."""
    for ratio in (frequency[:, 1] / frequency[:, 0]).tolist():
        near = Fraction(ratio).limit_denominator(LARGEST_INTEGER)
        odd = near.numerator % 2 and near.denominator % 2
        if odd and near.numerator <= LARGEST_INTEGER and abs(near / ratio - 1.0) < _SAME:
            remedy = "choose another frequency" if near != 1 else "put all modes on tone 0"
            raise SlipmodeError(
                f"frequency: of tone B is {near} times the frequency of tone A, so that they do "
                f"not have amplitudes of their own; {remedy}"
            )


def checked_ratio(ratio: float, modes: int) -> Fraction:
    """Return the ratio of the carriers of two modes; refuse what is none."""
    if modes != 2:
        raise SlipmodeError(f"ratio = {ratio:g}: needs two modes, A and B; leave it out")
    number = float(as_floats("ratio", ratio))
    found = (
        Fraction(number).limit_denominator(LARGEST_INTEGER) if 0.0 < number < 10.0 else Fraction(0)
    )
    if not (
        0 < found.numerator <= LARGEST_INTEGER and found != 1 and abs(found / number - 1.0) < _SAME
    ):
        raise SlipmodeError(
            f"ratio: must be a ratio of integers up to {LARGEST_INTEGER}, such as 3 or 1/3, and "
            f"not 1 (modes with one carrier: tones=(0, 0)), got {ratio}"
        )
    return found


def on_one_tone(reduced: Reduced, ratio: Fraction, carrier: Sequence[float] | None) -> Reduced:
    """Return the reduced structure with both carriers; mode A has its natural one by default.

    Raises
    ------
    SlipmodeError
        If no harmonic of the contacts or no mode is at the carrier of mode B.
    """
    if (ratio.numerator + ratio.denominator) % 2 and not reduced.even:
        raise SlipmodeError(
            f"ratio = {ratio}: contacts without lift-off have odd harmonics alone; the ratio must "
            "be of two odd integers"
        )
    given = reduced.frequency[:1] if carrier is None else as_floats("carrier", carrier)
    if given.shape != (1,):
        raise SlipmodeError(
            f"carrier: must be one frequency, of mode A, if ratio is given, got "
            f"{in_one_line(carrier)}"
        )
    omega, number = reduced.frequency, float(ratio)
    apart = number * float(given[0] / omega[1]) - 1.0
    if not abs(apart) <= FARTHEST:
        raise SlipmodeError(
            f"ratio = {ratio}: {ratio} times {given[0]:.5g} rad/s is {percentage(abs(apart))} "
            f"from mode {reduced.modes[1]} at {omega[1]:.5g} rad/s, which responds within "
            f"{percentage(FARTHEST)}; choose another mode or ratio, or the carrier of mode A"
        )
    return replace(reduced, ratio=number, carrier=given * [1.0, number])


def combinations_along(
    reduced: Reduced, start: Floats, end: Floats | None = None, *, transient: bool = False
) -> tuple[CombinationResonance, ...]:
    """Return the harmonics of the contacts that drive the slow flow.

    Arguments as of `combination_resonances`; the carriers of modes on one tone meet everywhere.
    """
    if reduced.ratio:
        return locked_resonances(checked_ratio(reduced.ratio, len(reduced.modes)), reduced.even)
    return combination_resonances(start, end, even=reduced.even, transient=transient)
