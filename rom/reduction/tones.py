"""Several modes on one tone: which modes one force can drive together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.short_repr import percentage

# Each amplitude acts on every other one through each contact. Beyond, harmonic balance of all
# degrees of freedom costs less.
_MOST_MODES = 40
# Relative distance of the frequencies of modes on one tone. A mode further away does not come into
# resonance with the force when friction changes its frequency, and responds as all other modes do.
FARTHEST = 0.15


def share_a_tone(tones: Sequence[int] | None, modes: int) -> bool:
    """Return whether several modes are on one tone; refuse what is neither that nor the default.

    `tones` has the tone of each mode. Default: mode j is on tone j.
    """
    if tones is None:
        return False
    numbers = as_floats("tones", list(tones)).tolist()
    if numbers == list(range(modes)):
        return False
    if len(numbers) != modes or not set(numbers) <= {0.0, 1.0}:
        raise SlipmodeError(
            f"tones: must be {modes} numbers, the tone 0 or 1 of each mode, got "
            f"{in_one_line(tones)}"
        )
    if set(numbers) != {0.0}:
        raise SlipmodeError(
            f"tones = {in_one_line(tones)}: two tones with several modes are not available; "
            "retain the modes of one tone, all on tone 0"
        )
    if modes > _MOST_MODES:
        raise SlipmodeError(
            f"modes: at most {_MOST_MODES} modes share a tone, got {modes}; retain modes near the "
            "forcing frequency, the others respond to it as well"
        )
    return True


def sliding_law(law: Friction | None, contacts: int) -> Elastic:
    """Return a law whose contacts do not lift off; refuse any other."""
    if isinstance(law, Elastic) and law.elements(contacts).odd:
        return law
    raise SlipmodeError(
        "law: several modes on one tone need contacts that slide and do not lift off "
        f"(rom.Jenkins, Iwan or Sliders), got {in_one_line(law)}"
    )


def check_tone(frequency: Floats, modes: Sequence[int], given: Mapping[str, object]) -> None:
    """Refuse modes (modes,) [rad/s] that cannot share a tone, and arguments that are given."""
    for key, value in given.items():
        if value is not None:
            raise SlipmodeError(f"{key}: must be left out if several modes share a tone")
    low, high = int(frequency.argmin()), int(frequency.argmax())
    apart = float(frequency[high] / frequency[low] - 1.0)
    if apart > FARTHEST:
        raise SlipmodeError(
            f"tones: mode {modes[low]} at {frequency[low]:.5g} rad/s and mode {modes[high]} at "
            f"{frequency[high]:.5g} rad/s are {percentage(apart)} apart, and one tone resonates "
            f"with modes within {percentage(FARTHEST)}; leave one of them out, it still responds "
            "to the force, or use a tone for each, tones=(0, 1)"
        )
