"""Results without time: steady states, resonance peaks and curves of many samples at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.branches.performance import resonance_peaks
from slipmode.rom.slow.steady_points import steady_points
from slipmode.runner.plan.excited import Excited
from slipmode.runner.scene.sections import Scene
from slipmode.runner.study.outputs.outputs import Batch, Outputs


@dataclass(frozen=True, eq=False)
class Loads:
    """The forces at the end of scenes."""

    excited: Excited
    frequency: Floats  # (samples, modes) [rad/s]
    # (samples, modes): F_j exp(i phase_j), modal, divided by `scale` [N kg^-1/2]: the friction
    # table is for limits of scale 1
    excitation: Complexes
    scale: Floats  # (samples, 1): Scale of limits and preloads; results are multiplied by it

    __repr__ = short_repr

    @classmethod
    def of(cls, scenes: Sequence[Scene], excited: Excited) -> Self:
        """Return the loads of scenes with the same modes."""
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
        excitation = phasor(excited.modal_force * force, phase) / scale
        return cls(excited, frequency, excitation, scale)


def steady_states(outputs: Outputs, model: Model, loads: Loads) -> Batch:
    """Return |a| and its phase."""
    patterns = loads.excited.force_patterns
    found = steady_points(model, loads.frequency, patterns, loads.excitation)
    a = loads.scale * found.amplitude
    values = {"steady": np.abs(a), "steady_phase": np.angle(a)}
    return Batch(values, found.reason, found.outside)


def curves(outputs: Outputs, model: Model, loads: Loads) -> Batch:
    """Return |a| over the frequency of a mode, (samples, modes, points).

    A sample with a refused point is refused.
    """
    assert outputs.curve is not None
    axis, n, modes = outputs.curve.frequency, len(loads.scale), loads.excited.modes
    if outputs.curve.mode not in modes:
        reason = f"outputs.curve.mode: nothing moves mode {outputs.curve.mode}"
        return Batch.refused("curve", (n, len(modes), axis.size), reason)
    frequency = np.repeat(loads.frequency, axis.size, axis=0)
    frequency[:, modes.index(outputs.curve.mode)] = np.tile(axis, n)
    excitation = np.repeat(loads.excitation, axis.size, axis=0)
    found = steady_points(model, frequency, loads.excited.force_patterns, excitation)
    a = np.abs(found.amplitude).reshape(n, axis.size, -1).swapaxes(1, 2)
    first = (
        next((why for why in found.reason[k : k + axis.size] if why), "")
        for k in range(0, len(frequency), axis.size)
    )
    outside = np.asarray(found.outside.reshape(n, axis.size).any(axis=1))
    return Batch({"curve": loads.scale[:, np.newaxis] * a}, list(first), outside)


def peaks(outputs: Outputs, model: Model, loads: Loads) -> Batch:
    """Return the highest resonance peak of modes, and its frequency."""
    shape, modes = loads.excitation.shape, loads.excited.modes
    peak, frequency = np.full(shape, np.nan), np.full(shape, np.nan)
    reason, outside = [""] * shape[0], np.zeros(shape[0], dtype=bool)
    for mode in outputs.resonance:
        if mode not in modes:
            return Batch.refused(
                "resonance", shape, f"outputs.resonance: nothing moves mode {mode}"
            )
        j = modes.index(mode)
        try:
            relative, frequency[:, j] = resonance_peaks(model, j, np.abs(loads.excitation[:, j]))
        except SlipmodeError as refusal:
            return Batch.refused("resonance", shape, str(refusal))
        peak[:, j] = loads.scale[:, 0] * relative
        outside |= np.isnan(relative)
    for k in np.flatnonzero(outside):
        reason[k] = f"amplitude: outside the friction table, to {model.table.amplitude_range}"
    return Batch({"resonance": peak, "resonance_frequency": frequency}, reason, outside)
