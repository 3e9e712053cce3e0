"""How long the stretches of a schedule have to be followed until nothing new happens in them.

Friction takes energy out of the difference of any two motions, so that what a breakpoint leaves
behind is forgotten at least as fast as the damping of the modes does it. Past many such times held
inputs have nothing new to show but beats, which repeat themselves; and what moves slowly against
that time may as well move faster: the amplitudes are steady ones all along.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.schedule import LIMIT_SCALE, Schedule, is_rate, rate_of

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


def limit_scale_over(
    stretches: tuple[Floats, Floats], names: Sequence[str]
) -> Callable[[Floats], Floats]:
    """Least scale of the limits around times (n,), as (n, 1), in stretches that follow t = 0.

    At a jump it is the lesser of both sides; 1 if the limits are no input.
    """
    if LIMIT_SCALE not in names:
        return lambda time: np.ones((time.size, 1))
    lengths, inputs = stretches
    ends = np.cumsum(lengths)
    starts = np.append(0.0, ends[:-1])
    begin, rate = (inputs[:, names.index(n)] for n in (LIMIT_SCALE, rate_of(LIMIT_SCALE)))
    slack = 1e-9 * lengths

    def scale(time: Floats) -> Floats:
        around = [np.searchsorted(ends + s, time, side="left") for s in (slack, -slack)]
        sides = [np.minimum(k, ends.size - 1) for k in around]
        values = [begin[k] + rate[k] * np.clip(time - starts[k], 0.0, lengths[k]) for k in sides]
        return np.asarray(np.minimum(*values)[:, np.newaxis])

    return scale


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
