"""A scene as a system structure package (SSP 1.0): its FMU, start values, units, experiment."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.xml_files import literal, to_bytes
from slipmode.fmu.variables.variable import UNITS
from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.scene.scene import Scene

fmpy = extra("fmpy", "fmu")

_COMPONENT = "structure"
_TYPES = {"Real": "Real", "Float64": "Real", "Boolean": "Boolean", "Enumeration": "Integer"}


@dataclass(frozen=True)
class Part:
    """A component of a system."""

    name: str
    fmu: Path  # For Co-Simulation
    values: Mapping[str, float] = field(default_factory=dict)  # Start values other than the FMU's

    @cached_property
    def variables(self) -> list[Any]:
        """Variables of the FMU's description."""
        return list(fmpy.read_model_description(str(self.fmu)).modelVariables)

    @property
    def connected(self) -> list[Any]:
        """Inputs and outputs, without arrays."""
        wanted = ("input", "output")
        return [v for v in self.variables if v.causality in wanted and not v.dimensions]


def write_ssp(
    fmu: Path,
    scene: Scene,
    output: Path,
    beside: Sequence[Part] = (),
    connections: Sequence[tuple[str, str]] = (),
) -> Path:
    """Write a system structure package with the FMU of a scene.

    The system has the connectors of the FMU, connected one to one, so that other components can
    be added; parameter sets have the start values.

    Parameters
    ----------
    fmu : path
    scene : Scene
    output : path
    beside : sequence of Part
        Other components of the system.
    connections : sequence of pairs of str
        From an output to an input, "structure.A_abs" to "controller.amplitude"; the FMU of the
        scene is called structure. Inputs of the system are not connected so.
    """
    structure = Part(_COMPONENT, fmu)
    parts = (structure, *beside)
    pairs = [_ends(parts, *pair) for pair in connections]
    files = {"SystemStructure.ssd": _description(scene, parts, pairs)}
    for part in parts:
        files[_parameter_file(part)] = _parameters(part)
        files[f"resources/{_file_of(part, scene)}"] = part.fmu.read_bytes()
    with replacing(output) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)  # dated 1980: the same scene gives the same bytes
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return output


def export_ssp(scene: Scene, output: Path, **options: Any) -> Path:
    """Export a scene by `export_fmu` into a system structure package."""
    with tempfile.TemporaryDirectory() as folder:
        fmu = export_fmu(scene, Path(folder) / f"{scene.name}.fmu", **options)
        return write_ssp(fmu, scene, output)


def _file_of(part: Part, scene: Scene) -> str:
    return f"{scene.name if part.name == _COMPONENT else part.name}.fmu"


def _parameter_file(part: Part) -> str:
    return f"resources/{'start' if part.name == _COMPONENT else part.name}.ssv"


def _ends(parts: Sequence[Part], start: str, end: str) -> dict[str, str]:
    """Return the attributes of a connection, from an output to an input."""
    said: dict[str, str] = {}
    for side, connector, kind in (("start", start, "output"), ("end", end, "input")):
        element, _, name = connector.partition(".")
        variables = [v for part in parts if part.name == element for v in part.connected]
        if name not in {v.name for v in variables if v.causality == kind}:
            raise SlipmodeError(f"connections: {connector} is not an {kind} of a component")
        said |= {f"{side}Element": element, f"{side}Connector": name}
    return said


def _spaces(**spaces: str) -> dict[str, str]:
    """Return the version and the name spaces of a document."""
    named = {"ssc": "Common"} | spaces
    space = "http://ssp-standard.org/SSP1/SystemStructure"
    declared = {f"xmlns:{prefix}": f"{space}{name}" for prefix, name in named.items()}
    return declared | {"version": "1.0"}


def _description(scene: Scene, parts: Sequence[Part], pairs: Sequence[Mapping[str, str]]) -> bytes:
    root = Element("ssd:SystemStructureDescription", _spaces(ssd="Description"), name=scene.title)
    system = SubElement(root, "ssd:System", name="system", description=scene.title)
    taken = {(pair["endElement"], pair["endConnector"]) for pair in pairs}
    shown = [v for v in parts[0].connected if (_COMPONENT, v.name) not in taken]
    _add_connectors(system, shown)
    elements = SubElement(system, "ssd:Elements")
    for part in parts:
        source = f"resources/{_file_of(part, scene)}"
        said = {"name": part.name, "type": "application/x-fmu-sharedlibrary", "source": source}
        component = SubElement(elements, "ssd:Component", said)
        _add_connectors(component, part.connected)
        bindings = SubElement(component, "ssd:ParameterBindings")
        SubElement(bindings, "ssd:ParameterBinding", source=_parameter_file(part))
    listed = SubElement(system, "ssd:Connections")
    for v in shown:
        said = {"startConnector": v.name, "endConnector": v.name}
        said["startElement" if v.causality == "output" else "endElement"] = _COMPONENT
        SubElement(listed, "ssd:Connection", said)
    for pair in pairs:
        SubElement(listed, "ssd:Connection", dict(pair))
    _add_units(SubElement(root, "ssd:Units"), [v for p in parts for v in p.connected])
    stop = literal(scene.run.duration)
    SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=stop)
    return to_bytes(root)


def _add_connectors(element: Element, variables: Sequence[Any]) -> None:
    connectors = SubElement(element, "ssd:Connectors")
    for v in variables:
        connector = SubElement(connectors, "ssd:Connector", name=v.name, kind=v.causality)
        unit = _unit_of(v)
        SubElement(connector, f"ssc:{_TYPES[v.type]}", {"unit": unit} if unit else {})


def _parameters(part: Part) -> bytes:
    """Return start values of parameters, inputs and amplitudes."""
    root = Element("ssv:ParameterSet", _spaces(ssv="ParameterValues"), name="start values")
    parameters = SubElement(root, "ssv:Parameters")
    given = [v for v in part.variables if v.start is not None and v.type in _TYPES]
    for v in given:
        parameter = SubElement(parameters, "ssv:Parameter", name=v.name)
        unit = _unit_of(v)
        value = literal(part.values[v.name]) if v.name in part.values else str(v.start)
        said = {"value": value} | ({"unit": unit} if unit else {})
        SubElement(parameter, f"ssv:{_TYPES[v.type]}", said)
    _add_units(SubElement(root, "ssv:Units"), given)
    return to_bytes(root)


def _unit_of(variable: Any) -> str | None:
    """Return its unit if SSP can express it: base units with whole exponents."""
    declared = variable.declaredType
    name = variable.unit or (declared.unit if declared is not None else None)
    return name if name in UNITS and (UNITS[name].base or name == "1") else None


def _add_units(units: Element, variables: Sequence[Any]) -> None:
    used = {_unit_of(v) for v in variables}
    for unit in UNITS.values():
        if unit.name in used:
            element = SubElement(units, "ssc:Unit", name=unit.name)
            base = {name: str(exponent) for name, exponent in unit.base.items()}
            SubElement(element, "ssc:BaseUnit", base)
