"""What a page can change: the inputs of a component, and how far."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor, log10
from typing import Any

import numpy as np

from slipmode.rom import Model, Units
from slipmode.rom.contact import slip_onset
from slipmode.rom.laws import is_homogeneous
from slipmode.runner.fmi import largest_forces
from slipmode.runner.plan import ModesPlan


def page_inputs(
    plan: ModesPlan, model: Model, units: Units, start: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Return name, label, unit, range and start value of each input.

    The values are in SI units; `per` is the unit in which they are shown.

    Parameters
    ----------
    plan : ModesPlan
    model : Model
    units : Units
        Units of the page.
    start : mapping of str to float
        Values with which the page starts, by name.
    """
    modes = plan.excited.modes
    forces = [f"force_{mode}" for mode in modes]
    scripted = np.abs(plan.schedule.extremes(forces)).max(axis=0)
    largest = largest_forces(plan, model)
    spans = frequency_spans(plan, model)
    found = []
    for j, mode in enumerate(modes):
        if plan.excited.force_patterns[j].any():
            value = start.get(forces[j], 0.0)
            most = largest.get(forces[j], 4.0 * float(scripted[j]) or 1.0)
            span = min(0.0, value), _rounded_up(max(most, value))
            found.append(_input(forces[j], f"Force {mode}", "N", span, value))
        name = f"frequency_{mode}"
        value = start.get(name, float(model.reduced.frequency[j]))
        shown = _input(name, f"Frequency {mode}", units.frequency, spans[j], value)
        found.append(shown | {"per": units.per_frequency})
    if is_homogeneous(model.law, model.reduced.n_contacts):
        span, value = limit_span(plan, model), start.get("limit_scale", 1.0)
        span = min(span[0], value), max(span[1], value)
        limits = _input("limit_scale", "Limits and preloads", "×", span, value)
        if force := plan.scene.static_force:
            limits |= {"label": "Static force", "unit": "N", "per": 1.0 / abs(force)}
        found.append(limits | {"log": True})
    return found


def _input(
    name: str, label: str, unit: str, span: tuple[float, float], value: float
) -> dict[str, Any]:
    described = {"name": name, "label": label, "unit": unit, "per": 1.0, "log": False}
    return described | {"least": span[0], "most": span[1], "start": float(value)}


def frequency_spans(plan: ModesPlan, model: Model) -> list[tuple[float, float]]:
    """Return for each mode the frequencies [rad/s] that a page covers.

    They contain the resonance at all amplitudes of the table, with the other mode at rest,
    and the frequencies of the scene, with a margin.
    """
    low, high = plan.schedule.frequency_range(plan.excited.modes)
    nodes = (model.table.node_a, model.table.node_b)
    spans = []
    for j, natural in enumerate(model.reduced.frequency.tolist()):
        moving = nodes[j][nodes[j] > 0.0]
        amplitude = np.zeros((moving.size, model.modes))
        amplitude[:, j] = moving
        stiffening = -(model.table(amplitude)[:, j] / moving).real
        resonance = np.sqrt(np.maximum(natural**2 + stiffening, 0.0))
        ends = np.append(resonance, (natural, low[j], high[j]))
        margin = 0.1 * np.ptp(ends) + 0.02 * natural  # beyond the peak, whose width is damping
        span = np.array([ends.min() - margin, ends.max() + margin])
        if (spin := model.reduced.spin) is not None:
            span = np.clip(span, *spin[j, 2:])
        spans.append((float(span[0]), float(span[1])))
    return spans


def limit_span(plan: ModesPlan, model: Model) -> tuple[float, float]:
    """Return factors on limits and preloads, from slip to stick.

    At the least of them the largest amplitudes of the scene end the friction table. At the largest
    one they are below the onset of slip.
    """
    amplitude = np.array(plan.amplitude)
    least = float((amplitude / model.table.amplitude_range).max())
    onset = [slip_onset(model.reduced, model.law, j)[0] for j in range(model.modes)]
    slips = [a / first for a, first in zip(amplitude, onset, strict=True) if first > 0.0]
    return min(least, 0.5), _rounded_up(max(slips, default=2.0))


def _rounded_up(value: float) -> float:
    """Return the next number of two digits."""
    unit = 10.0 ** (floor(log10(value)) - 1) if value > 0.0 else 1.0
    return ceil(value / unit - 1e-9) * unit
