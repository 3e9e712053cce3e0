"""How long the stretches of a schedule have to be followed until nothing new happens in them.

Friction takes energy out of the difference of any two motions, so that what a breakpoint leaves
behind is forgotten at least as fast as the damping of the modes does it. Past many such times held
inputs have nothing new to show but beats, which repeat themselves; and what moves slowly against
that time may as well move faster: the amplitudes are steady ones all along.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import short_repr
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.schedule import Schedule, is_rate, rate_of

_FORGOTTEN = 50.0  # decay times, also for a frequency to move by the width of a peak
_BEATS = 3.0  # periods
_AT_REST = 1e-2  # [rad] of a beat: no more of it is no beat


def shortened(
    schedule: Schedule, model: Model, modes: Sequence[Mode], names: Sequence[str]
) -> tuple[Floats, Floats]:
    """Stretches of a schedule, none longer than something new happens in it.

    A ramp that is shortened goes as far as before, as much faster.

    Parameters
    ----------
    modes : sequence of str
        Of the model.
    names : sequence of str
        Inputs of its component.

    Returns
    -------
    durations : (stretches,) ndarray
        [s]
    inputs : (stretches, len(names)) ndarray
        At their starts.
    """
    straight = schedule.stretches()
    lengths, inputs = straight.durations(), straight.inputs(names)
    shorter = np.minimum(lengths, _eventful(straight, model, modes))
    rates = [k for k, name in enumerate(names) if is_rate(name)]
    inputs[:, rates] *= (lengths / shorter)[:, np.newaxis]
    return shorter, inputs


@dataclass(frozen=True, eq=False)
class Stretches:
    """Shortened stretches that follow one another from t = 0.

    Attributes
    ----------
    durations : (stretches,) ndarray
        [s]
    inputs : (stretches, names) ndarray
        Inputs of the component at their starts.
    scene : (stretches,) ndarray
        Their durations in the scene [s].
    names : sequence of str
        Of the inputs.
    """

    durations: Floats
    inputs: Floats
    scene: Floats
    names: Sequence[str]

    __repr__ = short_repr

    def around(self, time: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Numbers of the stretches just before and just after times (n,)."""
        ends, slack = np.cumsum(self.durations), 1e-9 * self.durations
        before, after = (np.searchsorted(ends + s, time, side="left") for s in (slack, -slack))
        last = ends.size - 1
        return np.minimum(before, last), np.minimum(after, last)

    def values(self, name: str, time: Floats, number: NDArray[np.int64]) -> Floats:
        """Values (n,) of an input at times in the stretches of these numbers."""
        if name not in self.names:  # limits that nothing scripts are those of the model
            return np.ones(time.size)
        value, rate = (self.inputs[number, self.names.index(n)] for n in (name, rate_of(name)))
        return np.asarray(value + rate * self._since(time, number))

    def in_scene(self, time: Floats) -> Floats:
        """Times in the scene (n,) [s] of times in these stretches.

        Ramps are slower there by the factor of their duration; constant inputs last longer.
        """
        _, number = self.around(time)
        moving = [k for k, name in enumerate(self.names) if is_rate(name)]
        ramp = np.any(self.inputs[:, moving] != 0.0, axis=1)
        factor = np.where(ramp, self.scene / self.durations, 1.0)
        start = np.cumsum(self.scene) - self.scene
        return np.asarray(start[number] + factor[number] * self._since(time, number))

    def _since(self, time: Floats, number: NDArray[np.int64]) -> Floats:
        """Time since the starts of stretches (n,) [s]."""
        start = np.cumsum(self.durations) - self.durations
        return np.clip(time - start[number], 0.0, self.durations[number])


def _eventful(straight: Schedule, model: Model, modes: Sequence[Mode]) -> Floats:
    """How long something new can happen in each stretch at most (stretches,) [s]."""
    damping = model.reduced.modal_damping.min()
    if damping <= 0.0:
        return np.full(straight.steps, np.inf)
    decay = 2.0 / damping
    frequencies = [f"frequency_{mode}" for mode in modes]
    phases = [f"phase_{mode}" for mode in modes]
    ends = straight.inputs(frequencies), straight.at_ends(frequencies)
    moved = np.abs(ends[1] - ends[0]).max(axis=1)
    turned = np.abs(straight.at_ends(phases) - straight.inputs(phases)).max(axis=1)
    slow = _FORGOTTEN * decay * (1.0 + moved * decay + turned)
    return np.asarray(slow + _slowest_beat(ends, model, straight.durations()))


def _slowest_beat(ends: tuple[Floats, Floats], model: Model, lengths: Floats) -> Floats:
    """Period of the slowest beat of combination resonances in each stretch (stretches,) [s]."""
    longest = np.zeros(lengths.size)
    for term in model.combinations:
        beats = [f @ (term.n, term.m) - f[:, term.mode] for f in ends]
        beat = np.maximum(*np.abs(beats))
        turns = beat * lengths > _AT_REST
        period = 2.0 * np.pi / np.where(turns, beat, np.inf)
        longest = np.maximum(longest, _BEATS * period)
    return longest
