"""Response curves, backbones and performance curves as charts for Rerun."""

from __future__ import annotations

from functools import partial

import numpy as np

from slipmode import rom
from slipmode.rom.slow.branches.response_curve import CurveSizes
from slipmode.rom.slow.units import Shown
from slipmode.runner.view.charts import Axis, Chart, Layer
from slipmode.runner.view.plots import BLUE, GREEN, GREY, LINES, ORANGE, RED


def curve_charts(
    curve: rom.ResponseCurve | rom.ToneCurve | rom.Backbone | rom.PerformanceCurve, shown: Shown
) -> list[list[Chart]]:
    """Return rows of charts of a curve, as modal amplitudes or amplitudes of a DOF."""
    if isinstance(curve, rom.ToneCurve):
        at = shown.units.of_frequency(curve.frequency)
        axes = Axis(shown.units.frequency_label), Axis(shown.named("amplitude"))
        lines = [
            Layer(at, size, LINES[k % len(LINES)], f"|{mode}|")
            for k, (mode, size) in enumerate(curve.sizes(shown).items())
        ]
        return [[Chart("/amplitude", "Amplitude", *axes, lines)]]
    if isinstance(curve, rom.ResponseCurve):
        sizes = curve.sizes(shown)
        return [[_response(curve, j, shown, sizes) for j in range(curve.amplitude.shape[1])]]
    if isinstance(curve, rom.Backbone):
        size = curve.size(shown)
        x, y = Axis(shown.named("amplitude"), log=True), Axis("damping [-]")
        damping = Chart("/damping", "Damping ratio", x, y, [Layer(size, curve.damping)], False)
        layers = [Layer(size, shown.units.of_frequency(curve.frequency))]
        y = Axis(shown.units.frequency_label)
        return [[Chart("/frequency", "Frequency", x, y, layers, False), damping]]
    peak = curve.size(shown)
    x, best = Axis("friction limits, preloads: factor [-]", log=True), int(np.argmin(peak))
    words = curve.lowest_words(shown)
    point = Layer(curve.limit[[best]], peak[[best]], ORANGE, words, False, 5.0)
    layers = [Layer(curve.limit, peak), point]
    return [[Chart("/peak", "Resonance peak", x, Axis(shown.named("peak")), layers)]]


def _response(curve: rom.ResponseCurve, j: int, shown: Shown, sizes: CurveSizes) -> Chart:
    """Return the chart of |a_j|: stability, folds and Hopf points, bands of slow limit cycles."""
    mode, at = "AB"[j], partial(curve.in_units, units=shown.units)
    x, y = at(curve.parameter), sizes.points[:, j]
    ends = np.flatnonzero(np.diff(curve.branch)) + 1  # NaN there separates the branches
    layers = []
    for part, color, name in (
        (curve.stable, (BLUE, ORANGE)[j], "stable"),
        (~curve.stable, GREY, "unstable"),
    ):
        if part.any():
            own = np.insert(np.where(part, y, np.nan), ends, np.nan)
            layers.append(Layer(np.insert(x, ends, np.nan), own, color, name))
    kinds = np.array([point.kind for point in curve.special])
    where = at([point.parameter for point in curve.special])
    for kind, color in (("fold", RED), ("Hopf", GREEN)):
        own = kinds == kind
        if own.any():
            layers.append(Layer(where[own], sizes.special[own, j], color, kind, False, 5.0))
    cycles = curve.cycles
    if cycles.parameter.size:
        low, high = sizes.lowest[:, j], sizes.highest[:, j]
        bars = np.column_stack([low, high, np.full_like(low, np.nan)]).ravel()
        name = "slow limit cycles"
        layers.append(Layer(np.repeat(at(cycles.parameter), 3), bars, GREEN, name, width=1.0))
    axes = Axis(curve.label(shown.units)), Axis(shown.named(f"|{mode}|"))
    return Chart(f"/{mode}", f"|{mode}|", *axes, layers)
