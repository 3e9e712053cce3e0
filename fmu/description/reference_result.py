"""A reference experiment inside the FMU: stimuli and results, by the standard FMI-LS-REF."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from string import Template

import numpy as np

from slipmode.fmu.component import Component
from slipmode.fmu.description.options import ExportOptions, Stimuli
from slipmode.fmu.inputs import rate_of
from slipmode.fmu.stepping import StoppedError
from slipmode.fmu.variables.variable import Kind, Variable


def reference_files(
    component: Component, variables: Sequence[Variable], options: ExportOptions
) -> dict[str, bytes]:
    """Return the files of the experiment by `component`, with their manifest.

    The result ends where the experiment leaves the friction table. Without stimuli the inputs
    keep their start values.
    """
    start, stimuli, modes = options.start, options.stimuli, options.mode_names
    component.set_inputs(**{n: value for n, value in start.items() if n in component.input_names})
    parts = [[start.get(f"{mode}_{part}", 0.0) for part in ("re", "im")] for mode in modes]
    component.reset(amplitude=[complex(*each) for each in parts])
    if stimuli is None:
        held = {v.name: float(v.start or 0.0) for v in variables if v.kind is Kind.INPUT}
        steps = max(round(options.stop_time / options.interval), 1)
        values = np.tile(list(held.values()), (steps, 1))
        stimuli = Stimuli(tuple(held), np.full(steps, options.interval), values)
    read = [v for v in variables if v.causality == "output" and v.name in component.output_names]
    names = ["time", *(v.name for v in read if v.kind in (Kind.OUTPUT, Kind.START))]
    rows = _simulate(component, names, stimuli)
    manifest = Template(Path(__file__).with_name("fmi-ls-manifest.xml").read_text()).substitute(
        stop_time=float(options.stop_time),
        tolerance=float(options.tolerance),
        step_size=float(options.interval),
    )
    folder = "extra/org.fmi-standard.fmi-ls-ref"
    return {
        f"{folder}/fmi-ls-manifest.xml": manifest.encode(),
        f"{folder}/stimuli.csv": _csv(("time", *stimuli.names), _stimuli_rows(stimuli)),
        f"{folder}/reference.csv": _csv(names, rows),
    }


def _stimuli_rows(stimuli: Stimuli) -> list[list[float]]:
    """Return time and values, straight lines between rows; two rows at one time are a jump."""
    names, values = list(stimuli.names), stimuli.values
    time = np.append(0.0, np.cumsum(stimuli.durations))
    ends = values.copy()
    for k, name in enumerate(names):
        if rate_of(name) in names:
            ends[:, k] += stimuli.durations * values[:, names.index(rate_of(name))]
    rounding = 1e-12 * np.maximum(np.abs(values).max(axis=0), 1e-300)
    rows = [[0.0, *values[0]]]
    for k in range(1, len(time) - 1):
        if np.any(np.abs(values[k] - ends[k - 1]) > rounding):
            rows += [[time[k], *ends[k - 1]], [time[k], *values[k]]]
    return [*rows, [time[-1], *ends[-1]]]


def _simulate(component: Component, names: Sequence[str], stimuli: Stimuli) -> list[list[float]]:
    outputs = component.outputs()
    rows = [[outputs[name] for name in names]]
    for values, duration in zip(stimuli.values.tolist(), stimuli.durations.tolist(), strict=True):
        try:
            component.set_inputs(**dict(zip(stimuli.names, values, strict=True)))
            component.do_step(outputs["time"], duration)
        except StoppedError:
            break
        outputs = component.outputs()
        rows.append([outputs[name] for name in names])
    return rows


def _csv(names: Sequence[str], rows: Sequence[Sequence[float]]) -> bytes:
    lines = [",".join(names), *(",".join(repr(float(value)) for value in row) for row in rows)]
    return ("\n".join(lines) + "\n").encode()
