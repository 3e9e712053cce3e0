"""Resonance peaks of a mode by its backbone: at phase resonance |F| = 4 zeta Omega^2 |a|."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.slow.branches.backbone import LARGEST, SMALLEST, Backbone, tabulated_backbone
from slipmode.rom.table.model import Model


def resonance_peaks(model: Model, mode: int, force: Floats) -> tuple[Floats, Floats]:
    """Return the highest resonance peaks of a mode under modal forces |F_j| (n,), and frequencies.

    The other mode is at rest. Peaks |a| (n,) [kg^1/2 m] and their frequencies [rad/s] are NaN
    outside the friction table. A mode that is self-excited or undamped is refused.
    """
    curve, held = phase_resonances(model, mode)
    r, Omega = np.append(0.0, curve.amplitude), np.append(curve.frequency[0], curve.frequency)
    held = np.append(0.0, held)
    least = np.minimum.accumulate(held[::-1])[::-1]  # of the forces from there on
    below = np.searchsorted(least, force, side="right") - 1  # the last amplitude they exceed
    inside = below < held.size - 1
    k = np.where(inside, below, 0)
    part = (force - held[k]) / (held[k + 1] - held[k])
    peak, frequency = (each[k] + part * (each[k + 1] - each[k]) for each in (r, Omega))
    return np.where(inside, peak, np.nan), np.where(inside, frequency, np.nan)


def phase_resonances(model: Model, mode: int) -> tuple[Backbone, Floats]:
    """Return the backbone over the friction table, and the modal force at each amplitude."""
    largest = model.table.amplitude_range[mode]
    r = np.geomspace(SMALLEST * largest, LARGEST * largest, 2000)
    curve, _ = tabulated_backbone(model, mode, 0.0, r)
    if np.any(curve.damping <= 0.0):
        r = curve.amplitude[curve.damping <= 0.0][0]
        raise SlipmodeError(
            f"mode: {'AB'[mode]} has no damping at |a| = {r:.3g} kg^1/2 m, so it has no resonance "
            "peak; rom.limit_cycles finds the limit cycles of self-excited modes"
        )
    return curve, 4.0 * curve.damping * curve.frequency**2 * curve.amplitude
