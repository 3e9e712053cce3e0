"""Nodal-diameter and Campbell diagrams as charts for Rerun."""

from __future__ import annotations

import numpy as np

from slipmode import rom
from slipmode.rom.frequencies import RPM
from slipmode.rom.slow.units import Units
from slipmode.runner.view.charts import Axis, Chart, Layer
from slipmode.runner.view.plots import BLUE, GREEN, GREY, ORANGE, RED


def disk_charts(campbell: rom.CampbellDiagram, units: Units) -> list[Chart]:
    """Return both diagrams of a disk."""
    colors, y = (BLUE, ORANGE, GREEN), Axis(units.frequency_label)
    frequency = units.of_frequency(campbell.diameters.frequency)
    k, speed = np.arange(float(len(frequency))), np.array(campbell.rotor_speed)
    families, bands = [], []
    for family, values in enumerate(frequency.T):
        color = colors[family % len(colors)]
        families += [Layer(k, values, color), Layer(k, values, color, f"mode {family}", False, 4)]
        levels = np.column_stack((values, values, np.full_like(values, np.nan))).ravel()
        across = np.tile(np.append(speed, np.nan), values.size)
        bands.append(Layer(across, levels, color, width=0.5))
    lines, x = [], Axis("rotor speed [rpm]")
    for order in campbell.engine_orders:
        end = min(speed[1], units.per_frequency * 1.1 * frequency.max() / (order * RPM))
        if end > speed[0]:  # the chart ends there
            at = np.array((speed[0], end))
            lines.append(Layer(at, units.of_frequency(order * RPM * at), GREY, width=1.0))
    marks = np.array([(c.rotor_speed, c.frequency) for c in campbell.crossings]).reshape(-1, 2)
    met = Layer(marks[:, 0], units.of_frequency(marks[:, 1]), RED, "resonances", False, 5.0)
    return [
        Chart("/diameters", "Nodal diameters", Axis("nodal diameter"), y, families),
        Chart("/campbell", "Campbell diagram", x, y, [*bands, *lines, met]),
    ]
