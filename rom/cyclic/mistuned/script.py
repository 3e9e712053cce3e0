"""Inputs of a transient of a disk over time, straight lines between given times."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import SlipmodeError, ToneFlow
from slipmode.rom.common import Complexes, Floats, as_floats, in_one_line


def checked_script(time: ArrayLike, frequency: ArrayLike, magnitude: ArrayLike) -> list[Floats]:
    """Return increasing times [s], frequencies and magnitudes at these times, (samples,) each.

    The inputs are numbers, or arrays with a number for each time.
    """
    times = as_floats("time", time)
    if times.ndim != 1 or times.size == 0 or not np.all(np.diff(times) > 0.0):
        raise SlipmodeError(f"time: must be increasing numbers, got {in_one_line(time)}")
    script = [times]
    for name, value in (("frequency", frequency), ("magnitude", magnitude)):
        given = as_floats(name, value)
        if given.shape not in ((), times.shape) or not np.all(np.isfinite(given)):
            raise SlipmodeError(
                f"{name}: must be a finite number or {times.size}, one per time, got "
                f"{in_one_line(value)}"
            )
        script.append(np.array(np.broadcast_to(given, times.shape)))
    if not np.all(script[1] > 0.0):
        raise SlipmodeError(f"frequency: must be > 0, got {in_one_line(frequency)}")
    return script


def follow_script(script: list[Floats], flow: ToneFlow) -> Complexes:
    """Return displacements (samples, N, n_s) of a disk that is at rest at the first time."""
    time, *inputs = script
    moved = []
    steps = np.transpose([np.diff(time, prepend=time[0]), *inputs])
    for duration, frequency, magnitude in steps.tolist():
        flow.step(duration, frequency=frequency, magnitude=magnitude)
        moved.append(flow.displacement())
    return np.array(moved)
