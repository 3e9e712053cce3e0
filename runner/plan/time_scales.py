"""Whether a scene's frequencies, steps and windows are such as slow time is made for."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from slipmode.rom import Reduced, SlipmodeError
from slipmode.rom.validity import check_carrier
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.scene import Scene
from slipmode.runner.scene.schedule import Schedule

_LONGEST_STEP = 1e6  # periods
_MOST_SAMPLES = 1e8  # of all windows


def check_time_scales(
    scene: Scene, schedule: Schedule, modes: Sequence[Mode], reduced: Reduced
) -> None:
    """Refuse what no run could follow.

    Raises
    ------
    SlipmodeError
        Naming the key and what it may be.
    """
    reached = schedule.extremes([f"frequency_{mode}" for mode in modes])
    for mode, omega, *values in zip(modes, reduced.frequency, *reached, strict=True):
        key, unit = f"forcing.{mode}.frequency", scene.units.frequency
        check_carrier(key, mode, float(omega), np.array(values), unit)
    fastest = float(reached[1].max())
    longest = _LONGEST_STEP * 2 * pi / fastest
    if scene.run.step > longest:
        raise SlipmodeError(
            f"run.step: must be at most {longest:.3g} s, {_LONGEST_STEP:g} periods of the "
            f"forcing, got {scene.run.step:g}"
        )
    windows = (*scene.contact, *scene.elastic)
    per_second = fastest / (2 * pi)
    samples = sum(per_second * w.samples_per_period * (w.end - w.start) for w in windows)
    if samples > _MOST_SAMPLES:
        raise SlipmodeError(
            f"contact.window, elastic.window: would hold {samples:.2g} samples, allowed: "
            f"{_MOST_SAMPLES:g}; make them shorter or samples_per_period smaller"
        )
