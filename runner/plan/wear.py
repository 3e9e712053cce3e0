"""Friction limits that fall with the energy that the contacts dissipate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode.rom import Model, SlipmodeError
from slipmode.rom.arrays import Floats
from slipmode.runner.plan.excited import Excited
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.sections import Scene

# Breakpoints of the limits. Between two of them the limits fall by 1/400 of their whole change.
_BREAKPOINTS = 400
_LEAST = 0.05  # of the limits; the clamped contacts nearly open below
_CONVERGED = 1e-6  # change of the limits by an iteration
_ITERATIONS = 30  # the error after n of them is of the order of a^n / n!


def worn(excited: Excited, schedule: Schedule, model: Model, scene: Scene) -> Schedule:
    """Return the schedule with limits N_0 (1 - wear E) after the energy E is dissipated.

    The worn volume is proportional to E, and a clamped contact loses normal force in proportion to
    the worn depth (Fouvry, Liskiewicz, Kapsa, Hannel, Sauger, An energy description of wear
    mechanisms, Wear 255, 2003). All limits fall by the same share. E follows from the slow flow
    with these limits, by Picard's iteration. A path that leaves the table ends there.

    Raises SlipmodeError if the limits fall below 5 % of `limits.scale`.
    """
    given, wear = scene.limit_scale, scene.wear
    if wear == 0.0 or given is None:
        return schedule
    time = lost = np.zeros(2)
    for _ in range(_ITERATIONS):
        path = excited.follow(model, schedule.stretches(), scene.run.tolerance)
        before, time = np.interp(path.time, time, lost), path.time
        lost = np.minimum(wear * np.maximum.accumulate(path.energy), 1.0 - _LEAST)
        scripts = dict(schedule.scripts) | {"limit_scale": _fallen(given, time, lost)}
        schedule = replace(schedule, scripts=scripts)
        if np.abs(lost - before).max() <= _CONVERGED:
            break
    if lost[-1] >= 1.0 - _LEAST:
        raise SlipmodeError(
            f"limits.wear: the friction limits fall to {_LEAST:g} of limits.scale by t = "
            f"{time[np.argmax(lost)]:.4g} s; reduce limits.wear or run.duration"
        )
    return schedule


def _fallen(given: Script, time: Floats, lost: Floats) -> Script:
    """Return the limits `given` less the part that is lost at times (n,)."""
    levels = np.linspace(0.0, lost[-1], _BREAKPOINTS + 1)
    times = np.unique(np.concatenate((np.interp(levels, lost, time), given.breaks, [0.0])))
    left = 1.0 - np.interp(times, time, lost)
    values = (
        np.stack((given.value_before(times), given.value(times)), axis=1) * left[:, np.newaxis]
    )
    jumps = values[:, 0] != values[:, 1]
    kept = np.stack((jumps, np.ones_like(jumps)), axis=1)
    return Script(tuple(np.repeat(times, 1 + jumps).tolist()), tuple(values[kept].tolist()))
