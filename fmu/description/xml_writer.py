"""modelDescription.xml: what FMI 2.0 and 3.0 write alike."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.description import Description
from slipmode.fmu.variables.quantities import TABLE_STATUS, UNITS, Quantity
from slipmode.fmu.variables.variable import Causality, Kind, Variable

LOG_CATEGORIES = {
    "logEvents": "What the instance does, besides warnings and errors",
    "logStatusWarning": "Calls that did something else than was asked, and implausible inputs",
    "logStatusDiscard": "Steps and evaluations that could not be done, and why",
    "logStatusError": "Calls that were refused, and why",
}


def to_bytes(root: Element) -> bytes:
    """The document as UTF-8, indented."""
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def literal(value: float | bool) -> str:
    """A number or truth value as XML writes it."""
    return str(value).lower() if isinstance(value, bool) else repr(float(value))


class Writer(ABC):
    """What both versions write alike, and where each has its own way."""

    def __init__(self, description: Description) -> None:
        self.description = description
        self.variables = description.variables
        self.index = {variable.name: k for k, variable in enumerate(description.variables)}

    def to_bytes(self) -> bytes:
        """modelDescription.xml."""
        root = Element("fmiModelDescription", self._version() | self._attributes())
        self._add_interfaces(root)
        self._add_units(root)
        self._add_types(SubElement(root, "TypeDefinitions"))
        self._add_log_categories(root)
        self._add_experiment(root)
        self._add_variables(SubElement(root, "ModelVariables"))
        self._add_structure(SubElement(root, "ModelStructure"))
        return to_bytes(root)

    @abstractmethod
    def _version(self) -> dict[str, str]:
        """The version of the standard, and the instantiation token as it calls it."""

    @abstractmethod
    def _reference(self, name: str) -> str:
        """How the model structure refers to a variable."""

    @abstractmethod
    def _add_interfaces(self, root: Element) -> None:
        """Model Exchange and Co-Simulation, and what the FMU can do there."""

    @abstractmethod
    def _add_types(self, types: Element) -> None:
        """The declared types of the variables."""

    @abstractmethod
    def _add_variables(self, variables: Element) -> None:
        """The variables, in the order of their value references."""

    @abstractmethod
    def _add_structure(self, structure: Element) -> None:
        """Outputs, derivatives and initial unknowns, with what they depend on."""

    def _attributes(self) -> dict[str, str]:
        given = self.description
        return {
            "modelName": given.name,
            "description": given.description,
            "version": given.version,
            **given.origin.attributes(),
            "generationTool": f"slipmode {given.version}",
            "variableNamingConvention": "structured",
        }

    def _quantities(self) -> list[Quantity]:
        used = {v.quantity for v in self.variables}
        return [quantity for quantity in Quantity if quantity in used]

    def _add_units(self, root: Element) -> None:
        definitions = SubElement(root, "UnitDefinitions")
        used = {quantity.unit for quantity in self._quantities()}
        for unit in UNITS.values():
            if unit.name not in used:
                continue
            element = SubElement(definitions, "Unit", name=unit.name)
            if unit.base or unit.name == "1":
                base = {name: str(exponent) for name, exponent in unit.base.items()}
                SubElement(element, "BaseUnit", base)
            if unit.display:
                factor = literal(unit.factor)
                SubElement(element, "DisplayUnit", name=unit.display, factor=factor)

    def _unit_attributes(self, quantity: Quantity) -> dict[str, str]:
        unit = UNITS[quantity.unit]
        display = {"displayUnit": unit.display} if unit.display else {}
        return {"quantity": quantity.type_name, "unit": unit.name, **display}

    def _add_items(self, enumeration: Element) -> None:
        for item in TABLE_STATUS:
            SubElement(
                enumeration,
                "Item",
                name=item.name,
                value=str(item.value),
                description=item.description,
            )

    def _add_log_categories(self, root: Element) -> None:
        categories = SubElement(root, "LogCategories")
        for name, description in LOG_CATEGORIES.items():
            SubElement(categories, "Category", name=name, description=description)

    def _add_experiment(self, root: Element) -> None:
        experiment = self.description.experiment
        SubElement(
            root,
            "DefaultExperiment",
            startTime="0.0",
            stopTime=literal(experiment.stop_time),
            tolerance=literal(experiment.tolerance),
            stepSize=literal(experiment.step_size),
        )

    def _general(self, variable: Variable) -> dict[str, str]:
        """Attributes that a variable has whatever its type."""
        attributes = {
            "name": variable.name,
            "valueReference": str(self.index[variable.name]),
            "description": variable.description,
            "causality": variable.causality.value,
            "variability": variable.variability,
        }
        if variable.initial is not None:
            attributes["initial"] = variable.initial
        return attributes

    def _typed(self, variable: Variable) -> dict[str, str]:
        """Attributes that belong to a variable's type."""
        attributes = {}
        if variable.quantity is not None:
            attributes["declaredType"] = variable.quantity.type_name
        for name, value in (
            ("min", variable.minimum),
            ("max", variable.maximum),
            ("nominal", variable.nominal),
            ("start", variable.start),
        ):
            if value is not None:
                attributes[name] = literal(value)
        if variable.derivative_of is not None:
            attributes["derivative"] = self._reference(variable.derivative_of)
        if variable.kind is Kind.START:  # at discontinuities of forces, in Model Exchange
            attributes["reinit"] = "true"
        return attributes

    def _unknown(self, variable: Variable, needs: Sequence[str], key: str) -> dict[str, str]:
        ordered = sorted(needs, key=lambda name: self.index[name])
        return {
            key: self._reference(variable.name),
            "dependencies": " ".join(self._reference(name) for name in ordered),
        }

    def _outputs(self) -> list[tuple[Variable, Sequence[str]]]:
        """Outputs with what they depend on; a state depends on itself."""
        return [
            (v, v.needs or (v.name,)) for v in self.variables if v.causality is Causality.OUTPUT
        ]

    def _derivatives(self) -> list[tuple[Variable, Sequence[str]]]:
        """Derivatives of the states with what they depend on."""
        return [(v, v.needs) for v in self.variables if v.kind is Kind.RATE]

    def _initial_unknowns(self) -> list[tuple[Variable, Sequence[str]]]:
        """What is calculated at the start, with the start values it depends on."""
        exact = {v.name for v in self.variables if v.start is not None}
        unknowns: list[tuple[Variable, Sequence[str]]] = []
        for variable in self.variables:
            if variable.initial == "calculated":
                needs = [name for name in variable.needs if name in exact]
                unknowns.append((variable, [*needs, *variable.parameters]))
        return unknowns
