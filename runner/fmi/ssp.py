"""A scene as a system structure package (SSP 1.0): its FMU, start values, units, experiment."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, register_namespace

from slipmode.fmu.archive.contents import Archive
from slipmode.fmu.description.xml_writer import literal, to_bytes
from slipmode.fmu.variables.quantities import UNITS
from slipmode.rom.files import replacing
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.scene.scene import Scene

_SSP = "http://ssp-standard.org/SSP1/SystemStructure"
_NAMES = {"ssd": "Description", "ssc": "Common", "ssv": "ParameterValues"}
_COMPONENT = "structure"
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same scene gives the same bytes
_TYPES = {"Real": "Real", "Float64": "Real", "Boolean": "Boolean", "Enumeration": "Integer"}


def write_ssp(fmu: Path, scene: Scene, output: Path) -> Path:
    """Put the FMU of a scene into a system structure package.

    The system has the connectors of the FMU, connected one to one, so that other components can
    be put beside it; a parameter set has its start values.
    """
    for prefix, name in _NAMES.items():
        register_namespace(prefix, f"{_SSP}{name}")
    variables = Archive(fmu).description.modelVariables
    files = {
        "SystemStructure.ssd": _structure(scene, variables),
        "resources/start.ssv": _parameters(variables),
        f"resources/{scene.name}.fmu": fmu.read_bytes(),
    }
    with replacing(output) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return output


def export_ssp(scene: Scene, output: Path, **options: Any) -> Path:
    """`export_fmu` into a system structure package."""
    with tempfile.TemporaryDirectory() as folder:
        fmu = export_fmu(scene, Path(folder) / f"{scene.name}.fmu", **options)
        return write_ssp(fmu, scene, output)


def _tag(prefix: str, name: str) -> str:
    return f"{{{_SSP}{_NAMES[prefix]}}}{name}"


def _structure(scene: Scene, variables: Sequence[Any]) -> bytes:
    root = Element(_tag("ssd", "SystemStructureDescription"), version="1.0", name=scene.title)
    system = SubElement(root, _tag("ssd", "System"), name="system", description=scene.title)
    connected = [v for v in variables if v.causality in ("input", "output") and not v.dimensions]
    _add_connectors(system, connected)
    elements = SubElement(system, _tag("ssd", "Elements"))
    component = SubElement(
        elements,
        _tag("ssd", "Component"),
        name=_COMPONENT,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{scene.name}.fmu",
    )
    _add_connectors(component, connected)
    bindings = SubElement(component, _tag("ssd", "ParameterBindings"))
    SubElement(bindings, _tag("ssd", "ParameterBinding"), source="resources/start.ssv")
    connections = SubElement(system, _tag("ssd", "Connections"))
    for v in connected:
        said = {"startConnector": v.name, "endConnector": v.name}
        said["startElement" if v.causality == "output" else "endElement"] = _COMPONENT
        SubElement(connections, _tag("ssd", "Connection"), said)
    _add_units(SubElement(root, _tag("ssd", "Units")), connected)
    SubElement(
        root,
        _tag("ssd", "DefaultExperiment"),
        startTime="0.0",
        stopTime=literal(scene.run.duration),
    )
    return to_bytes(root)


def _add_connectors(element: Element, variables: Sequence[Any]) -> None:
    connectors = SubElement(element, _tag("ssd", "Connectors"))
    for v in variables:
        connector = SubElement(connectors, _tag("ssd", "Connector"), name=v.name, kind=v.causality)
        unit = _unit_of(v)
        SubElement(connector, _tag("ssc", _TYPES[v.type]), {"unit": unit} if unit else {})


def _parameters(variables: Sequence[Any]) -> bytes:
    """Start values of parameters, inputs and amplitudes."""
    root = Element(_tag("ssv", "ParameterSet"), version="1.0", name="start values")
    parameters = SubElement(root, _tag("ssv", "Parameters"))
    given = [v for v in variables if v.start is not None and v.type in _TYPES]
    for v in given:
        parameter = SubElement(parameters, _tag("ssv", "Parameter"), name=v.name)
        unit = _unit_of(v)
        said = {"value": str(v.start)} | ({"unit": unit} if unit else {})
        SubElement(parameter, _tag("ssv", _TYPES[v.type]), said)
    _add_units(SubElement(root, _tag("ssv", "Units")), given)
    return to_bytes(root)


def _unit_of(variable: Any) -> str | None:
    """Its unit, where SSP can say it: base units with whole exponents."""
    declared = variable.declaredType
    name = variable.unit or (declared.unit if declared is not None else None)
    return name if name in UNITS and (UNITS[name].base or name == "1") else None


def _add_units(units: Element, variables: Sequence[Any]) -> None:
    used = {_unit_of(v) for v in variables}
    for unit in UNITS.values():
        if unit.name in used:
            element = SubElement(units, _tag("ssc", "Unit"), name=unit.name)
            base = {name: str(exponent) for name, exponent in unit.base.items()}
            SubElement(element, _tag("ssc", "BaseUnit"), base)
