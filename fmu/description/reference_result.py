"""A reference result inside the FMU, as the layered standard FMI-LS-REF lays it out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement, register_namespace

from slipmode.fmu.component import Component
from slipmode.fmu.description.description import Experiment
from slipmode.fmu.description.xml_writer import to_bytes
from slipmode.fmu.stepping import StoppedError
from slipmode.fmu.variables.variable import Causality, Kind, Variable

_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
_RESULT = "reference.csv"


def reference_files(
    component: Component,
    mode_names: Sequence[str],
    start: Mapping[str, float],
    variables: Sequence[Variable],
    experiment: Experiment,
) -> dict[str, bytes]:
    """The default experiment by `component`, with a manifest that tells what it is.

    Where the experiment leaves the friction table, the result ends.
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
    rows = _simulate(component, names, experiment)
    lines = [",".join(("time", *names))]
    lines += [",".join(repr(value) for value in row) for row in rows]
    return {
        f"{_FOLDER}/fmi-ls-manifest.xml": _manifest(),
        f"{_FOLDER}/{_RESULT}": ("\n".join(lines) + "\n").encode(),
    }


def _simulate(
    component: Component, names: Sequence[str], experiment: Experiment
) -> list[list[float]]:
    steps = max(round(experiment.stop_time / experiment.reference_step), 1)
    rows = []
    for k in range(steps + 1):
        outputs = component.outputs()
        rows.append([outputs[name] for name in ("time", *names)])
        if k < steps:
            try:
                component.do_step(outputs["time"], experiment.reference_step)
            except StoppedError:
                break
    return rows


def _manifest() -> bytes:
    register_namespace("fmi-ls", _NAMESPACE)
    described = {
        f"{{{_NAMESPACE}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
        f"{{{_NAMESPACE}}}fmi-ls-version": "1.0.0-alpha.1",
        f"{{{_NAMESPACE}}}fmi-ls-description": "Files related to the FMU",
    }
    root = Element("fmiReferences", described)
    SubElement(
        root,
        "Related",
        source=_RESULT,
        type="text/csv",
        role="result",
        description="Result of the default experiment in Co-Simulation",
    )
    return to_bytes(root)
