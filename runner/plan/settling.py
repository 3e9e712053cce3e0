"""How long the stretches of a schedule have to be followed until their motion only repeats.

Friction takes energy out of the difference of any two motions, so that the influence of a
breakpoint decays at least as fast as the damping of the modes. Many decay times later, constant
inputs only produce beats, which repeat. Inputs that are slow compared with the decay may as well
move faster: the amplitudes are steady all along.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.schedule import Schedule, is_rate, rate_of


def shortened(
    schedule: Schedule, model: Model, modes: Sequence[Mode], names: Sequence[str]
) -> tuple[Floats, Floats]:
    """Return the stretches of a schedule, none longer than its motion changes.

    A ramp that is shortened goes as far as before, but faster. `names` are the inputs of the
    model's component. Returns the durations (stretches,) [s], and the inputs at their starts,
    (stretches, names).
    """
    straight = schedule.stretches()
    lengths, inputs = straight.durations(), straight.inputs(names)
    shorter = np.minimum(lengths, _settling_time(straight, model, modes))
    rates = [k for k, name in enumerate(names) if is_rate(name)]
    inputs[:, rates] *= (lengths / shorter)[:, np.newaxis]
    return shorter, inputs


@frozen
class Stretches:
    """Shortened stretches that follow one another from t = 0."""

    durations: Floats  # (stretches,) [s]
    inputs: Floats  # (stretches, names): Inputs of the component at their starts
    scene: Floats  # (stretches,): Their durations in the scene [s]
    names: Sequence[str]  # Names of the inputs

    def around(self, time: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the numbers of the stretches just before and just after times (n,)."""
        ends, slack = np.cumsum(self.durations), 1e-9 * self.durations
        before, after = (np.searchsorted(ends + s, time, side="left") for s in (slack, -slack))
        last = ends.size - 1
        return np.minimum(before, last), np.minimum(after, last)

    def values(self, name: str, time: Floats, number: NDArray[np.int64]) -> Floats:
        """Return values (n,) of an input at times in the stretches of these numbers."""
        if name not in self.names:  # limits without a script have the scale 1
            return np.ones(time.size)
        value, rate = (self.inputs[number, self.names.index(n)] for n in (name, rate_of(name)))
        return np.asarray(value + rate * self._since(time, number))

    def in_scene(self, time: Floats) -> Floats:
        """Return the times in the scene (n,) [s] of times in these stretches.

        Ramps are slower there by the factor of their duration; constant inputs last longer.
        """
        _, number = self.around(time)
        moving = [k for k, name in enumerate(self.names) if is_rate(name)]
        ramp = np.any(self.inputs[:, moving] != 0.0, axis=1)
        factor = np.where(ramp, self.scene / self.durations, 1.0)
        start = np.cumsum(self.scene) - self.scene
        return np.asarray(start[number] + factor[number] * self._since(time, number))

    def _since(self, time: Floats, number: NDArray[np.int64]) -> Floats:
        """Return the times since the starts of stretches (n,) [s]."""
        start = np.cumsum(self.durations) - self.durations
        return np.clip(time - start[number], 0.0, self.durations[number])


def _settling_time(straight: Schedule, model: Model, modes: Sequence[Mode]) -> Floats:
    """Return how long the motion of each stretch changes at most, (stretches,) [s]."""
    damping = model.reduced.modal_damping.min()
    if damping <= 0.0:
        return np.full(straight.steps, np.inf)
    decay = 2.0 / damping
    frequencies, phases = ([f"{name}_{m}" for m in modes] for name in ("frequency", "phase"))
    start, end = straight.inputs(frequencies), straight.at_ends(frequencies)
    moved = np.abs(end - start).max(axis=1)
    turned = np.abs(straight.at_ends(phases) - straight.inputs(phases)).max(axis=1)
    longest = np.zeros(straight.steps)
    for term in model.combinations:
        beat = np.maximum(*(np.abs(f @ (term.n, term.m) - f[:, term.mode]) for f in (start, end)))
        turns = beat * straight.durations() > 1e-2  # [rad], below which a beat has no influence
        period = 2.0 * np.pi / np.where(turns, beat, np.inf)
        longest = np.maximum(longest, 3.0 * period)
    # 50 decay times, and as many for each width of a peak that a frequency moves: ramps lag by a
    # fiftieth of their height (tests/runner/plan/test_settling.py)
    return np.asarray(50.0 * decay * (1.0 + moved * decay + turned) + longest)
