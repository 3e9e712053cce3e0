"""An experiment inside the FMU, as the layered standard FMI-LS-REF has it.

Stimuli and reference results: any importer can run it again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, register_namespace

import numpy as np

from slipmode.fmu.component import Component
from slipmode.fmu.description.description import Experiment
from slipmode.fmu.description.xml_writer import literal, to_bytes
from slipmode.fmu.stepping import StoppedError
from slipmode.fmu.variables.variable import Causality, Kind, Variable
from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import short_repr

_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
_STIMULI, _RESULT = "stimuli.csv", "reference.csv"
_SAME = 1e-12  # relative: rounding


@dataclass(frozen=True, eq=False)
class Stimuli:
    """What an experiment does to the inputs, step by step.

    Attributes
    ----------
    names : sequence of str
        Of inputs, each with its rate.
    durations : (steps,) ndarray
        Communication steps [s].
    values : (steps, names) ndarray
        At the start of each step, right of jumps; during it inputs move at their rates.
    """

    names: Sequence[str]
    durations: Floats
    values: Floats

    __repr__ = short_repr

    @classmethod
    def constant(cls, start: Mapping[str, float], experiment: Experiment) -> Stimuli:
        """The inputs that an FMU starts with, all the time."""
        steps = max(round(experiment.stop_time / experiment.reference_step), 1)
        values = np.tile(list(start.values()), (steps, 1))
        return cls(tuple(start), np.full(steps, experiment.reference_step), values)

    def rows(self) -> list[list[float]]:
        """Time and values, straight lines between; two rows at one time are a jump."""
        time = np.append(0.0, np.cumsum(self.durations))
        moved = np.zeros_like(self.values)
        for k, name in enumerate(self.names):
            rate = name.replace("_", "_rate_", 1) if "_rate" not in name else ""
            rate = "limit_scale_rate" if name == "limit_scale" else rate
            if rate in self.names:
                moved[:, k] = self.durations * self.values[:, list(self.names).index(rate)]
        ends = self.values + moved
        scale = np.maximum(np.abs(self.values).max(axis=0), 1e-300)
        rows = [[0.0, *self.values[0]]]
        for k in range(1, len(time) - 1):
            if np.any(np.abs(self.values[k] - ends[k - 1]) > _SAME * scale):
                rows += [[time[k], *ends[k - 1]], [time[k], *self.values[k]]]
        return [*rows, [time[-1], *ends[-1]]]


def reference_files(
    component: Component,
    mode_names: Sequence[str],
    start: Mapping[str, float],
    variables: Sequence[Variable],
    experiment: Experiment,
    stimuli: Stimuli | None = None,
) -> dict[str, bytes]:
    """The experiment by `component`, with a manifest that tells what it is.

    Where the experiment leaves the friction table, the result ends. Without stimuli the inputs
    stay as they are at the start.
    """
    names = [
        v.name
        for v in variables
        if v.causality is Causality.OUTPUT
        and v.kind in (Kind.OUTPUT, Kind.START)
        and v.name in component.output_names
    ]
    inputs = {name: value for name, value in start.items() if name in component.input_names}
    component.set_inputs(**inputs)
    component.reset(
        amplitude=[
            complex(start.get(f"{mode}_re", 0.0), start.get(f"{mode}_im", 0.0))
            for mode in mode_names
        ]
    )
    if stimuli is None:
        given = {v.name: v.start for v in variables if v.name in component.input_names}
        held = {name: float(value or 0.0) for name, value in given.items()}
        stimuli = Stimuli.constant(held, experiment)
    rows = _simulate(component, names, stimuli)
    return {
        f"{_FOLDER}/fmi-ls-manifest.xml": _manifest(experiment),
        f"{_FOLDER}/{_STIMULI}": _csv(("time", *stimuli.names), stimuli.rows()),
        f"{_FOLDER}/{_RESULT}": _csv(("time", *names), rows),
    }


def _simulate(component: Component, names: Sequence[str], stimuli: Stimuli) -> list[list[float]]:
    rows = []
    for k in range(len(stimuli.durations) + 1):
        outputs = component.outputs()
        rows.append([outputs[name] for name in ("time", *names)])
        if k < len(stimuli.durations):
            try:
                component.set_inputs(
                    **dict(zip(stimuli.names, stimuli.values[k].tolist(), strict=True))
                )
                component.do_step(outputs["time"], float(stimuli.durations[k]))
            except StoppedError:
                break
    return rows


def _csv(names: Sequence[str], rows: Sequence[Sequence[float]]) -> bytes:
    lines = [",".join(names), *(",".join(repr(float(value)) for value in row) for row in rows)]
    return ("\n".join(lines) + "\n").encode()


def _manifest(experiment: Experiment) -> bytes:
    register_namespace("fmi-ls", _NAMESPACE)
    described = {
        f"{{{_NAMESPACE}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
        f"{{{_NAMESPACE}}}fmi-ls-version": "1.0.0-rc.1",
        f"{{{_NAMESPACE}}}fmi-ls-description": "Stimuli and results of the scene of the FMU",
    }
    root = Element("fmiReferences", described)
    element = SubElement(
        root,
        "Experiment",
        name="scene",
        description="The scene in Co-Simulation: before each step all inputs and rates are set to "
        "their last row at that time, or to what lies between rows",
        startTime="0.0",
        stopTime=literal(experiment.stop_time),
        tolerance=literal(experiment.tolerance),
        stepSize=literal(experiment.reference_step),
    )
    SubElement(element, "Stimuli", source=_STIMULI, type="text/csv")
    SubElement(element, "References", source=_RESULT, type="text/csv")
    return to_bytes(root)
