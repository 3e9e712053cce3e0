"""Response curves, backbones and performance curves as charts for Rerun."""

from __future__ import annotations

import numpy as np

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.slow.branches.response_curve import CurveSizes
from slipmode.rom.slow.units import Shown
from slipmode.runner.view.charts import Axis, Chart, Layer
from slipmode.runner.view.labels import BLUE, GREEN, GREY, ORANGE, RED


def curve_charts(
    curve: rom.ResponseCurve | rom.Backbone | rom.PerformanceCurve, shown: Shown
) -> list[list[Chart]]:
    """Return rows of charts of a curve, as modal amplitudes or amplitudes of a DOF."""
    if isinstance(curve, rom.ResponseCurve):
        sizes = curve.sizes(shown)
        return [[_response(curve, j, shown, sizes) for j in range(curve.amplitude.shape[1])]]
    if isinstance(curve, rom.Backbone):
        size = shown.size(curve.motion)[:, curve.mode]
        x, frequency = (
            Axis(shown.named("amplitude"), log=True),
            Axis(f"frequency [{shown.units.frequency}]"),
        )
        values = [Layer(size, shown.units.of_frequency(curve.frequency))]
        damping = [Layer(size, curve.damping)]
        return [
            [
                Chart("/frequency", "Frequency", x, frequency, values, from_zero=False),
                Chart("/damping", "Damping ratio", x, Axis("damping [-]"), damping, False),
            ]
        ]
    peak = curve.size(shown)
    x, best = Axis("friction limits, preloads: factor [-]", log=True), int(np.argmin(peak))
    lowest = f"lowest at {curve.limit[best]:.3g}"
    point = Layer(curve.limit[[best]], peak[[best]], ORANGE, lowest, False, 5.0)
    layers = [Layer(curve.limit, peak), point]
    return [[Chart("/peak", "Resonance peak", x, Axis(shown.named("peak")), layers)]]


def _response(curve: rom.ResponseCurve, j: int, shown: Shown, sizes: CurveSizes) -> Chart:
    """Return the chart of |a_j|: stability, folds and Hopf points, bands of slow limit cycles."""
    of_frequency, mode = curve.vary.startswith("frequency"), "AB"[j]
    unit = shown.units.frequency if of_frequency else "-"

    def at(parameter: Floats) -> Floats:
        return shown.units.of_frequency(parameter) if of_frequency else parameter

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
    for kind, color in (("fold", RED), ("Hopf", GREEN)):
        found = [k for k, point in enumerate(curve.special) if point.kind == kind]
        if found:
            where = np.array([curve.special[k].parameter for k in found])
            tops = sizes.special[found, j]
            layers.append(Layer(at(where), tops, color, kind, False, 5.0))
    cycles = curve.cycles
    if cycles.parameter.size:
        low, high = sizes.lowest[:, j], sizes.highest[:, j]
        bars = np.column_stack([low, high, np.full_like(low, np.nan)]).ravel()
        name = "slow limit cycles"
        layers.append(Layer(np.repeat(at(cycles.parameter), 3), bars, GREEN, name, width=1.0))
    label = f"{curve.vary.replace('_', ' ')} [{unit}]"
    return Chart(f"/{mode}", f"|{mode}|", Axis(label), Axis(shown.named(f"|{mode}|")), layers)
