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
from slipmode.rom.storage.files import replacing
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.scene.scene import Scene

fmpy = extra("fmpy", "fmu")
simulation = extra("fmpy.simulation", "fmu")

_COMPONENT = "structure"
# Types of SSP 1.0 for types of FMI; of FMI 3.0 the integers that 32 bits hold
_TYPES = {
    **dict.fromkeys(("Real", "Float32", "Float64"), "Real"),
    **dict.fromkeys(("Integer", "Enumeration", "Int8", "UInt8", "Int16", "UInt16"), "Integer"),
    **{"Int32": "Integer", "Boolean": "Boolean", "String": "String"},
}


@dataclass(frozen=True)
class Part:
    """A component of a system."""

    name: str
    fmu: Path  # For Co-Simulation
    values: Mapping[str, float] = field(default_factory=dict)  # Start values other than the FMU's

    @cached_property
    def variables(self) -> dict[str, Any]:
        """Scalar variables that SSP 1.0 has a type for, by name."""
        found = fmpy.read_model_description(str(self.fmu)).modelVariables
        return {v.name: v for v in found if v.type in _TYPES and not v.dimensions}

    def start(self, variable: Any) -> str | None:
        """Return the start value of a variable; None if it has none or none may be set."""
        value = self.values.get(variable.name)
        if value is not None:
            return str(int(value)) if _TYPES[variable.type] == "Integer" else literal(value)
        return variable.start if simulation.settable_in_instantiated(variable) else None


def write_ssp(
    fmu: Path,
    scene: Scene,
    output: Path,
    beside: Sequence[Part] = (),
    connections: Sequence[tuple[str, str]] = (),
) -> Path:
    """Write a system structure package with the FMU of a scene.

    Parameter sets have the start values. An input is a connector only if it is connected, because
    importers write 0 to connectors that nothing is connected to.

    Parameters
    ----------
    fmu : path
    scene : Scene
    output : path
    beside : sequence of Part
        Other components of the system.
    connections : sequence of pairs of str
        From an output to an input, "structure.A_abs" to "controller.amplitude"; the FMU of the
        scene is called structure. A name without a component is an input or output of the system,
        "force_A" to "structure.force_A".
    """
    parts = {part.name: part for part in (Part(_COMPONENT, fmu), *beside)}
    ends = [_ends(parts, *pair) for pair in connections]
    files = {"SystemStructure.ssd": _description(scene, parts, ends)}
    for part in parts.values():
        starts = {name: (v, part.start(v)) for name, v in part.variables.items()}
        files[_parameter_file(part)] = to_bytes(_parameter_set(starts))
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


def _ends(parts: Mapping[str, Part], start: str, end: str) -> dict[str, str]:
    """Return the attributes of a connection, from an output to an input."""
    said: dict[str, str] = {}
    for side, connector, kind in (("start", start, "output"), ("end", end, "input")):
        element, inside, name = connector.partition(".")
        if inside:
            found = parts[element].variables.get(name) if element in parts else None
            if found is None or found.causality != kind:
                raise SlipmodeError(f"connections: {connector} is not an {kind} of a component")
            said |= {f"{side}Element": element, f"{side}Connector": name}
        else:
            said[f"{side}Connector"] = connector
    if len(said) == 2:
        raise SlipmodeError(f"connections: {start} and {end} are both without a component")
    return said


def _spaces(**spaces: str) -> dict[str, str]:
    """Return the version and the name spaces of a document."""
    named = {"ssc": "Common"} | spaces
    space = "http://ssp-standard.org/SSP1/SystemStructure"
    declared = {f"xmlns:{prefix}": f"{space}{name}" for prefix, name in named.items()}
    return declared | {"version": "1.0"}


def _description(
    scene: Scene, parts: Mapping[str, Part], connections: Sequence[Mapping[str, str]]
) -> bytes:
    root = Element("ssd:SystemStructureDescription", _spaces(ssd="Description"), name=scene.title)
    system = SubElement(root, "ssd:System", name="system", description=scene.title)
    shown, starts = {}, {}  # connectors of the system, and the start values of its inputs
    for said in connections:
        for side, other, kind in (("start", "end", "input"), ("end", "start", "output")):
            if f"{side}Element" not in said:
                part, name = parts[said[f"{other}Element"]], said[f"{side}Connector"]
                variable = part.variables[said[f"{other}Connector"]]
                shown[name] = kind, variable
                if kind == "input":
                    starts[name] = variable, part.start(variable)
    _add_connectors(system, shown)
    if starts:
        bindings = SubElement(system, "ssd:ParameterBindings")
        values = SubElement(SubElement(bindings, "ssd:ParameterBinding"), "ssd:ParameterValues")
        values.append(_parameter_set(starts))
    elements = SubElement(system, "ssd:Elements")
    for part in parts.values():
        source = f"resources/{_file_of(part, scene)}"
        said = {"name": part.name, "type": "application/x-fmu-sharedlibrary", "source": source}
        component = SubElement(elements, "ssd:Component", said)
        connected = {c["endConnector"] for c in connections if c.get("endElement") == part.name}
        variables = part.variables.items()
        wanted = {n: v for n, v in variables if n in connected or v.causality == "output"}
        _add_connectors(component, {n: (v.causality, v) for n, v in wanted.items()})
        bindings = SubElement(component, "ssd:ParameterBindings")
        SubElement(bindings, "ssd:ParameterBinding", source=_parameter_file(part))
    if connections:
        listed = SubElement(system, "ssd:Connections")
        for said in connections:
            SubElement(listed, "ssd:Connection", dict(said))
    _add_units(root, "ssd:Units", [v for part in parts.values() for v in part.variables.values()])
    stop = literal(scene.run.duration)
    SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=stop)
    return to_bytes(root)


def _add_connectors(element: Element, wanted: Mapping[str, tuple[str, Any]]) -> None:
    """Add connectors by name, each with its kind and the variable that has its type and unit."""
    if wanted:  # an empty list is not valid
        connectors = SubElement(element, "ssd:Connectors")
    for name, (kind, v) in wanted.items():
        connector = SubElement(connectors, "ssd:Connector", name=name, kind=kind)
        SubElement(connector, f"ssc:{_TYPES[v.type]}", _unit_of(v))


def _parameter_set(starts: Mapping[str, tuple[Any, str | None]]) -> Element:
    """Return the start values of variables by name."""
    root = Element("ssv:ParameterSet", _spaces(ssv="ParameterValues"), name="start values")
    parameters = SubElement(root, "ssv:Parameters")
    for name, (v, value) in starts.items():
        if value is not None:
            parameter = SubElement(parameters, "ssv:Parameter", name=name)
            SubElement(parameter, f"ssv:{_TYPES[v.type]}", {"value": value} | _unit_of(v))
    _add_units(root, "ssv:Units", [v for v, value in starts.values() if value is not None])
    return root


def _unit_of(variable: Any) -> dict[str, str]:
    """Return the attribute of its unit if SSP can express it by base units of whole exponents."""
    declared = variable.declaredType
    name: Any = variable.unit or (declared.unit if declared is not None else None)
    said = name in UNITS and (UNITS[name].base or name == "1")
    return {"unit": name} if said and _TYPES[variable.type] == "Real" else {}


def _add_units(root: Element, tag: str, variables: Sequence[Any]) -> None:
    """Add the units of variables; an empty list is not valid."""
    used = {_unit_of(v).get("unit") for v in variables}
    listed = Element(tag)
    for unit in UNITS.values():
        if unit.name in used:
            element = SubElement(listed, "ssc:Unit", name=unit.name)
            base = {name: str(exponent) for name, exponent in unit.base.items()}
            SubElement(element, "ssc:BaseUnit", base)
    if len(listed):
        root.append(listed)
