"""Answers without time: steady states, resonance peaks and curves of many samples at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.branches.performance import resonance_peaks
from slipmode.rom.slow.steady_points import steady_points
from slipmode.runner.plan.amplitude_range import Excited
from slipmode.runner.scene.scene import Scene
from slipmode.runner.study.outputs.asked import Asked


@dataclass(frozen=True, eq=False)
class Loads:
    """What acts at the end of scenes.

    Attributes
    ----------
    frequency : (samples, modes) ndarray
        [rad/s]
    excitation : (samples, modes) complex ndarray
        F_j exp(i phase_j), modal [N kg^-1/2].
    scale : (samples, 1) ndarray
        Of limits and preloads.
    """

    frequency: Floats
    excitation: Complexes
    scale: Floats

    __repr__ = short_repr

    @classmethod
    def of(cls, scenes: Sequence[Scene], excited: Excited) -> Self:
        """Of scenes with the same modes."""
        shape = len(scenes), len(excited.modes)
        frequency = np.tile(excited.reduced.frequency, (shape[0], 1))
        force, phase, scale = np.zeros(shape), np.zeros(shape), np.ones((shape[0], 1))
        for k, scene in enumerate(scenes):
            end = scene.run.duration
            if scene.limit_scale is not None:
                scale[k] = scene.limit_scale.value_before(end)
            for j, mode in enumerate(excited.modes):
                if (forcing := scene.forcing.get(mode)) is not None:
                    force[k, j] = forcing.amplitude.value_before(end)
                    frequency[k, j] = forcing.frequency.value_before(end)
                    phase[k, j] = forcing.phase.value_before(end)
        modal = [excited.reduced.modal_force(j, f) for j, f in enumerate(excited.force_patterns)]
        return cls(frequency, phasor(np.array(modal) * force, phase), scale)


@dataclass(frozen=True, eq=False)
class Found:
    """Arrays (samples, modes of the model, ...) by name, and what `Batch` has besides."""

    values: dict[str, Floats]
    reason: list[str]
    outside: Flags

    __repr__ = short_repr


def steady_states(asked: Asked, excited: Excited, model: Model, loads: Loads) -> Found:
    """|a| and its phase."""
    found = steady_points(
        model, loads.frequency, excited.force_patterns, loads.excitation / loads.scale
    )
    a = loads.scale * found.amplitude
    values = {"steady": np.abs(a), "steady_phase": np.angle(a)}
    return Found(values, found.reason, found.outside)


def curves(asked: Asked, excited: Excited, model: Model, loads: Loads) -> Found:
    """|a| at each frequency of a mode, (samples, modes, points); one refused refuses all."""
    assert asked.curve is not None
    axis, n = asked.curve.frequency, len(loads.scale)
    if asked.curve.mode not in excited.modes:
        refused = f"outputs.curve.mode: nothing moves mode {asked.curve.mode}"
        return _refused("curve", (n, len(excited.modes), axis.size), refused)
    frequency = np.repeat(loads.frequency, axis.size, axis=0)
    frequency[:, excited.modes.index(asked.curve.mode)] = np.tile(axis, n)
    excitation = np.repeat(loads.excitation / loads.scale, axis.size, axis=0)
    found = steady_points(model, frequency, excited.force_patterns, excitation)
    a = np.abs(found.amplitude).reshape(n, axis.size, -1).swapaxes(1, 2)
    first = (
        next((why for why in found.reason[k : k + axis.size] if why), "")
        for k in range(0, len(frequency), axis.size)
    )
    outside = np.asarray(found.outside.reshape(n, axis.size).any(axis=1))
    return Found({"curve": loads.scale[:, np.newaxis] * a}, list(first), outside)


def peaks(asked: Asked, excited: Excited, model: Model, loads: Loads) -> Found:
    """The highest resonance peak of modes, and its frequency."""
    shape = loads.excitation.shape
    peak, frequency = np.full(shape, np.nan), np.full(shape, np.nan)
    reason, outside = [""] * shape[0], np.zeros(shape[0], dtype=bool)
    for mode in asked.resonance:
        if mode not in excited.modes:
            return _refused("resonance", shape, f"outputs.resonance: nothing moves mode {mode}")
        j = excited.modes.index(mode)
        force = np.abs(loads.excitation[:, j]) / loads.scale[:, 0]
        try:
            relative, frequency[:, j] = resonance_peaks(model, j, force)
        except SlipmodeError as refusal:
            return _refused("resonance", shape, str(refusal))
        peak[:, j] = loads.scale[:, 0] * relative
        outside |= np.isnan(relative)
    for k in np.flatnonzero(outside):
        reason[k] = f"amplitude: outside the friction table, to {model.table.amplitude_range}"
    return Found({"resonance": peak, "resonance_frequency": frequency}, reason, outside)


def _refused(name: str, shape: tuple[int, ...], why: str) -> Found:
    empty = np.full(shape, np.nan)
    return Found({name: empty}, [why] * shape[0], np.zeros(shape[0], dtype=bool))
