"""Inputs of a transient of a disk over time."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.tone.tone_flow import ToneFlow


@frozen
class Script:
    """Inputs of a transient, straight lines between its times.

    Attributes
    ----------
    time : (samples,) ndarray
        Increasing [s].
    frequency, magnitude : (samples,) ndarray
        Inputs at these times.
    """

    time: Floats
    frequency: Floats
    magnitude: Floats

    @classmethod
    def of(cls, time: ArrayLike, frequency: ArrayLike, magnitude: ArrayLike) -> Self:
        """Return a script of numbers, or of arrays with a number for each time."""
        times = as_floats("time", time)
        if times.ndim != 1 or times.size == 0 or not np.all(np.diff(times) > 0.0):
            raise SlipmodeError(f"time: must be increasing numbers, got {in_one_line(time)}")
        inputs = []
        for name, value in (("frequency", frequency), ("magnitude", magnitude)):
            given = as_floats(name, value)
            if given.shape not in ((), times.shape) or not np.all(np.isfinite(given)):
                raise SlipmodeError(
                    f"{name}: must be a finite number or {times.size}, one per time, got "
                    f"{in_one_line(value)}"
                )
            inputs.append(np.array(np.broadcast_to(given, times.shape)))
        if not np.all(inputs[0] > 0.0):
            raise SlipmodeError(f"frequency: must be > 0, got {in_one_line(frequency)}")
        return cls(times, *inputs)

    def follow(self, flow: ToneFlow) -> Complexes:
        """Return displacements (samples, N, n_s) of a disk that is at rest at the first time."""
        moved = []
        steps = (np.diff(self.time, prepend=self.time[0]), self.frequency, self.magnitude)
        for duration, frequency, magnitude in np.transpose(steps).tolist():
            flow.step(duration, frequency=frequency, magnitude=magnitude)
            moved.append(flow.displacement())
        return np.array(moved)
