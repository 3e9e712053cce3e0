"""XML files of an FMU: modelDescription.xml in FMI 2.0 and 3.0, and further files of FMI 3.0."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.options import MODEL_IDENTIFIER, ExportOptions
from slipmode.fmu.variables.variable import UNITS, Kind, Quantity, Type, Variable


def to_bytes(root: Element) -> bytes:
    """Return the document as UTF-8, indented."""
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def literal(value: float | bool) -> str:
    """Return a number or truth value as XML writes it."""
    return str(value).lower() if isinstance(value, bool) else repr(float(value))


@dataclass(frozen=True)
class Fmi3Description:
    """modelDescription.xml of FMI 3.0: types have own elements, the structure has references."""

    options: ExportOptions
    variables: Sequence[Variable]
    summary: str  # description of the model
    token: str  # instantiation token: the content hash of the resources
    sources: Sequence[str]  # C files in sources/

    def to_bytes(self) -> bytes:
        """Return the document."""
        options, release = self.options, version("slipmode")
        attributes = {
            "modelName": options.name,
            "description": self.summary,
            "version": release,
            **(options.origin.attributes() if options.origin else {}),
            "generationTool": f"slipmode {release}",
            "variableNamingConvention": "flat",
        }
        root = Element("fmiModelDescription", self._version() | attributes)
        self._add_interfaces(root)
        quantities = {v.quantity for v in self.variables}
        used = [quantity for quantity in Quantity if quantity in quantities]
        _add_units(SubElement(root, "UnitDefinitions"), used)
        types = SubElement(root, "TypeDefinitions")
        for quantity in used:
            self._add_type(types, quantity)
        _add_log_categories(SubElement(root, "LogCategories"))
        experiment = {"startTime": 0.0, "stopTime": options.stop_time}
        experiment |= {"tolerance": options.tolerance, "stepSize": options.step_size}
        SubElement(root, "DefaultExperiment", {k: literal(v) for k, v in experiment.items()})
        listed = SubElement(root, "ModelVariables")
        for variable in self.variables:
            self._add_variable(listed, variable)
        self._add_structure(SubElement(root, "ModelStructure"))
        return to_bytes(root)

    @cached_property
    def index(self) -> dict[str, int]:
        """Value references by name."""
        return {variable.name: k for k, variable in enumerate(self.variables)}

    @cached_property
    def _states(self) -> set[str]:
        """Names of the continuous states; modes that share a tone have none."""
        return {v.derivative_of for v in self.variables if v.derivative_of is not None}

    def _version(self) -> dict[str, str]:
        return {"fmiVersion": "3.0", "instantiationToken": self.token}

    def _reference(self, name: str) -> str:
        """Return how the model structure refers to a variable."""
        return str(self.index[name])

    def _add_interfaces(self, root: Element) -> None:
        common = {"modelIdentifier": MODEL_IDENTIFIER}
        common |= _true("canGetAndSetFMUState", "canSerializeFMUState")
        order = {}
        if self._states:
            common |= _true("providesDirectionalDerivatives", "providesAdjointDerivatives")
            order = {"maxOutputDerivativeOrder": "1"}
            SubElement(root, "ModelExchange", common)
        simulation = _true(
            "canHandleVariableCommunicationStepSize",
            "mightReturnEarlyFromDoStep",
            "providesIntermediateUpdate",
            "canReturnEarlyAfterIntermediateUpdate",
            "hasEventMode",
        )
        SubElement(root, "CoSimulation", common | simulation | order)

    def _add_type(self, types: Element, quantity: Quantity) -> None:
        named = {"name": quantity.type_name, "description": quantity.description}
        if quantity.unit:
            SubElement(types, "Float64Type", named | _unit_attributes(quantity))
        else:
            named["quantity"] = quantity.type_name
            _add_items(SubElement(types, "EnumerationType", named))

    def _add_variable(self, variables: Element, variable: Variable) -> None:
        attributes = self._general(variable) | self._typed(variable)
        if variable.causality == "output":
            attributes["intermediateUpdate"] = "true"
        tags = {Type.ENUMERATION: "Enumeration", Type.BOOLEAN: "Boolean"}
        element = SubElement(variables, tags.get(variable.type, "Float64"), attributes)
        if variable.size is not None:
            SubElement(element, "Dimension", start=str(variable.size))

    def _add_structure(self, structure: Element) -> None:
        tags = ("Output", "ContinuousStateDerivative", "InitialUnknown")
        for tag, unknowns in zip(tags, self._unknowns("valueReference"), strict=True):
            for unknown in unknowns:
                SubElement(structure, tag, unknown)

    def _general(self, variable: Variable) -> dict[str, str]:
        """Return the attributes of variables of any type."""
        attributes = {
            "name": variable.name,
            "valueReference": str(self.index[variable.name]),
            "description": variable.description,
            "causality": variable.causality,
            "variability": variable.variability,
        }
        if variable.initial is not None:
            attributes["initial"] = variable.initial
        return attributes

    def _typed(self, variable: Variable) -> dict[str, str]:
        """Return the attributes that belong to the type of a variable."""
        attributes = {}
        if variable.quantity is not None:
            attributes["declaredType"] = variable.quantity.type_name
        values = {"min": variable.minimum, "max": variable.maximum, "nominal": variable.nominal}
        values["start"] = variable.start
        attributes |= {name: literal(each) for name, each in values.items() if each is not None}
        if variable.derivative_of is not None:
            attributes["derivative"] = self._reference(variable.derivative_of)
        if variable.kind is Kind.START:  # at discontinuities of forces, in Model Exchange
            attributes["reinit"] = "true"
        return attributes

    def _unknowns(self, key: str) -> tuple[list[dict[str, str]], ...]:
        """Return outputs, derivatives and initial unknowns, with the variables they depend on.

        Parameters are dependencies at the start only. A state depends on itself.
        """

        def listed(variable: Variable, known: set[str]) -> dict[str, str]:
            needs = known.intersection(variable.needs or (variable.name,))
            ordered = sorted(needs, key=lambda name: self.index[name])
            dependencies = " ".join(map(self._reference, ordered))
            return {key: self._reference(variable.name), "dependencies": dependencies}

        inputs = {v.name for v in self.variables if v.kind is Kind.INPUT}
        running = inputs | self._states
        exact = {v.name for v in self.variables if v.start is not None}
        return (
            [listed(v, running) for v in self.variables if v.causality == "output"],
            [listed(v, running) for v in self.variables if v.kind is Kind.RATE],
            [listed(v, exact) for v in self.variables if v.initial == "calculated"],
        )


class Fmi2Description(Fmi3Description):
    """FMI 2.0: types are nested in types and variables; the structure counts variables from 1."""

    def _version(self) -> dict[str, str]:
        return {"fmiVersion": "2.0", "guid": self.token}

    def _reference(self, name: str) -> str:
        return str(self.index[name] + 1)

    def _add_interfaces(self, root: Element) -> None:
        common = {"modelIdentifier": MODEL_IDENTIFIER} | _true(
            "canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate", "canSerializeFMUstate"
        )
        interfaces = {}
        simulation = _true("canHandleVariableCommunicationStepSize", "canInterpolateInputs")
        if self._states:
            common |= _true("providesDirectionalDerivative")
            interfaces["ModelExchange"] = _true("completedIntegratorStepNotNeeded")
            simulation["maxOutputDerivativeOrder"] = "1"
        interfaces["CoSimulation"] = simulation
        for tag, own in interfaces.items():
            files = SubElement(SubElement(root, tag, common | own), "SourceFiles")
            for name in self.sources:
                SubElement(files, "File", name=name)

    def _add_type(self, types: Element, quantity: Quantity) -> None:
        named = {"name": quantity.type_name, "description": quantity.description}
        simple = SubElement(types, "SimpleType", named)
        if quantity.unit:
            SubElement(simple, "Real", _unit_attributes(quantity))
        else:
            _add_items(SubElement(simple, "Enumeration", quantity=quantity.type_name))

    def _add_variable(self, variables: Element, variable: Variable) -> None:
        scalar = SubElement(variables, "ScalarVariable", self._general(variable))
        SubElement(scalar, variable.type.name.capitalize(), self._typed(variable))

    def _add_structure(self, structure: Element) -> None:
        groups = ("Outputs", "Derivatives", "InitialUnknowns")
        for group, unknowns in zip(groups, self._unknowns("index"), strict=True):
            element = SubElement(structure, group) if unknowns else structure
            for unknown in unknowns:
                SubElement(element, "Unknown", unknown)


def terminals_xml(variables: Sequence[Variable]) -> bytes:
    """Return the terminals: one for the force on each mode, and one for each contact DOF."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphics = SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100.0", "y1": "-100.0", "x2": "100.0", "y2": "100.0"}
    SubElement(graphics, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    SubElement(graphics, "Icon", corners)
    terminals = SubElement(root, "Terminals")
    made: dict[str, Element] = {}
    for variable in variables:
        name, words, member = _terminal(variable.name)
        if not name:
            continue
        if name not in made:
            attributes = {"name": name, "matchingRule": "bus", "description": words}
            made[name] = SubElement(terminals, "Terminal", attributes)
        said = {"variableName": variable.name, "memberName": member, "variableKind": "signal"}
        SubElement(made[name], "TerminalMemberVariable", said)
    return to_bytes(root)


def _terminal(name: str) -> tuple[str, str, str]:
    """Return the terminal of a variable, its description, and the name there; else ""."""
    if force := re.fullmatch(r"((?:force|frequency|phase)(?:_rate)?)_([AB])", name):
        member, mode = force.groups()
        return f"excitation_{mode}", f"Force {mode}, its frequency and phase", member
    if contact := re.fullmatch(r"(contact_(\d+))_([xvf])", name):
        terminal, dof, member = contact.groups()
        return terminal, f"Motion and force at contact DOF {dof}", member
    return "", "", ""


def build_description(sources: Sequence[str]) -> bytes:
    """Return how to build the library from C files in sources/."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=MODEL_IDENTIFIER)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(files, "IncludeDirectory", name=".")
    SubElement(configuration, "Library", name="m", description="libm, where it is one apart")
    return to_bytes(root)


def _true(*names: str) -> dict[str, str]:
    return dict.fromkeys(names, "true")


def _add_units(definitions: Element, used: Sequence[Quantity]) -> None:
    names = {quantity.unit for quantity in used}
    for unit in (unit for unit in UNITS.values() if unit.name in names):
        element = SubElement(definitions, "Unit", name=unit.name)
        if unit.base or unit.name == "1":
            SubElement(element, "BaseUnit", {name: str(n) for name, n in unit.base.items()})
        if unit.display:
            SubElement(element, "DisplayUnit", name=unit.display, factor=literal(unit.factor))


def _unit_attributes(quantity: Quantity) -> dict[str, str]:
    unit = UNITS[quantity.unit]
    display = {"displayUnit": unit.display} if unit.display else {}
    return {"quantity": quantity.type_name, "unit": unit.name, **display}


def _add_items(enumeration: Element) -> None:
    inside = "The amplitudes are well inside the friction table"
    near_edge = "An amplitude is near the edge of the friction table"
    SubElement(enumeration, "Item", name="inside", value="1", description=inside)
    SubElement(enumeration, "Item", name="near_edge", value="2", description=near_edge)


def _add_log_categories(categories: Element) -> None:
    for name, description in (
        ("logEvents", "What the instance does, besides warnings and errors"),
        ("logStatusWarning", "Calls with another effect than requested, and implausible inputs"),
        ("logStatusDiscard", "Steps and evaluations that could not be done, and why"),
        ("logStatusError", "Calls that were refused, and why"),
    ):
        SubElement(categories, "Category", name=name, description=description)
