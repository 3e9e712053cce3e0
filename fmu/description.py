"""modelDescription.xml and buildDescription.xml for FMI 2.0 and 3.0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from fmu.quantities import TABLE_STATUS, UNITS, Quantity
from fmu.variable import Causality, Kind, Type, Variable

FmiVersion = Literal[2, 3]
MODEL_IDENTIFIER = "slipmode"

LOG_CATEGORIES = {
    "logEvents": "What the instance does, besides warnings and errors",
    "logStatusWarning": "Calls that did something else than they asked for",
    "logStatusDiscard": "Steps and evaluations that could not be done, and why",
    "logStatusError": "Calls that were refused, and why",
}

_TYPE_TAGS = {
    2: {Type.REAL: "Real", Type.ENUMERATION: "Enumeration", Type.BOOLEAN: "Boolean"},
    3: {Type.REAL: "Float64", Type.ENUMERATION: "Enumeration", Type.BOOLEAN: "Boolean"},
}


@dataclass(frozen=True)
class Experiment:
    """The experiment that an importer offers first.

    Attributes
    ----------
    stop_time : float
        [s]
    step_size : float
        Communication step [s].
    tolerance : float
    """

    stop_time: float
    step_size: float
    tolerance: float


@dataclass(frozen=True)
class Description:
    """What modelDescription.xml says.

    Attributes
    ----------
    name : str
        Of the model.
    description : str
    version : str
        Of slipmode.
    token : str
        Instantiation token: the content hash of the resources.
    variables : sequence of Variable
    experiment : Experiment
    sources : sequence of str
        C files in sources/.
    """

    name: str
    description: str
    version: str
    token: str
    variables: Sequence[Variable]
    experiment: Experiment
    sources: Sequence[str]

    def to_xml(self, fmi: FmiVersion) -> bytes:
        """modelDescription.xml."""
        return to_bytes(_Fmi2(self).root() if fmi == 2 else _Fmi3(self).root())

    def build_xml(self) -> bytes:
        """sources/buildDescription.xml of FMI 3.0."""
        root = Element("fmiBuildDescription", fmiVersion="3.0")
        configuration = SubElement(root, "BuildConfiguration", modelIdentifier=MODEL_IDENTIFIER)
        files = SubElement(configuration, "SourceFileSet", language="C99")
        for name in self.sources:
            SubElement(files, "SourceFile", name=name)
        SubElement(configuration, "Library", name="m", description="libm, where it is one apart")
        return to_bytes(root)


def to_bytes(root: Element) -> bytes:
    """The document as UTF-8, indented."""
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def literal(value: float | bool) -> str:
    """A number or truth value as XML writes it."""
    return str(value).lower() if isinstance(value, bool) else repr(float(value))


class _Writer:
    """What both versions have in common."""

    fmi: FmiVersion

    def __init__(self, description: Description) -> None:
        self.description = description
        self.variables = description.variables
        self.index = {variable.name: k for k, variable in enumerate(description.variables)}

    def attributes(self) -> dict[str, str]:
        given = self.description
        return {
            "modelName": given.name,
            "description": given.description,
            "version": given.version,
            "license": "MIT",
            "generationTool": f"slipmode {given.version}",
            "variableNamingConvention": "structured",
        }

    def quantities(self) -> list[Quantity]:
        used = {v.quantity for v in self.variables}
        return [quantity for quantity in Quantity if quantity in used]

    def add_units(self, root: Element) -> None:
        definitions = SubElement(root, "UnitDefinitions")
        used = {quantity.unit for quantity in self.quantities()}
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

    def unit_attributes(self, quantity: Quantity) -> dict[str, str]:
        unit = UNITS[quantity.unit]
        display = {"displayUnit": unit.display} if unit.display else {}
        return {"quantity": quantity.type_name, "unit": unit.name, **display}

    def add_items(self, enumeration: Element) -> None:
        for item in TABLE_STATUS:
            SubElement(
                enumeration,
                "Item",
                name=item.name,
                value=str(item.value),
                description=item.description,
            )

    def add_log_categories(self, root: Element) -> None:
        categories = SubElement(root, "LogCategories")
        for name, description in LOG_CATEGORIES.items():
            SubElement(categories, "Category", name=name, description=description)

    def add_experiment(self, root: Element) -> None:
        experiment = self.description.experiment
        SubElement(
            root,
            "DefaultExperiment",
            startTime="0.0",
            stopTime=literal(experiment.stop_time),
            tolerance=literal(experiment.tolerance),
            stepSize=literal(experiment.step_size),
        )

    def general(self, variable: Variable) -> dict[str, str]:
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

    def typed(self, variable: Variable) -> dict[str, str]:
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
            attributes["derivative"] = self.reference(variable.derivative_of)
        if variable.kind is Kind.START:  # where a force jumps, in Model Exchange
            attributes["reinit"] = "true"
        return attributes

    def reference(self, name: str) -> str:
        """How the model structure refers to a variable."""
        raise NotImplementedError

    def unknown(self, variable: Variable, needs: Sequence[str], key: str) -> dict[str, str]:
        ordered = sorted(needs, key=lambda name: self.index[name])
        return {
            key: self.reference(variable.name),
            "dependencies": " ".join(self.reference(name) for name in ordered),
        }

    def outputs(self) -> list[tuple[Variable, Sequence[str]]]:
        """Outputs with what they depend on; a state depends on itself."""
        return [
            (v, v.needs or (v.name,)) for v in self.variables if v.causality is Causality.OUTPUT
        ]

    def differentiable(self) -> str:
        """Whether everything has directional derivatives: they are announced for all or none."""
        return literal(not any(v.marched for v in self.variables))

    def derivatives(self) -> list[Variable]:
        return [v for v in self.variables if v.kind is Kind.RATE]

    def initial_unknowns(self) -> list[tuple[Variable, Sequence[str]]]:
        """What is calculated at the start, with the start values it depends on."""
        exact = {v.name for v in self.variables if v.start is not None}
        unknowns: list[tuple[Variable, Sequence[str]]] = []
        for variable in self.variables:
            if variable.initial == "calculated":
                needs = [name for name in variable.needs if name in exact]
                unknowns.append((variable, [*needs, *variable.parameters]))
        return unknowns


class _Fmi2(_Writer):
    fmi: FmiVersion = 2

    def reference(self, name: str) -> str:
        return str(self.index[name] + 1)

    def root(self) -> Element:
        given = self.description
        version = {"fmiVersion": "2.0", "guid": given.token}
        root = Element("fmiModelDescription", version | self.attributes())
        common = {
            "modelIdentifier": MODEL_IDENTIFIER,
            "canNotUseMemoryManagementFunctions": "true",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
            "providesDirectionalDerivative": self.differentiable(),
        }
        exchange = SubElement(
            root, "ModelExchange", common, completedIntegratorStepNotNeeded="true"
        )
        simulation = SubElement(
            root,
            "CoSimulation",
            common,
            canHandleVariableCommunicationStepSize="true",
            canInterpolateInputs="true",
        )
        for interface in (exchange, simulation):
            files = SubElement(interface, "SourceFiles")
            for name in given.sources:
                SubElement(files, "File", name=name)
        self.add_units(root)
        types = SubElement(root, "TypeDefinitions")
        for quantity in self.quantities():
            simple = SubElement(
                *(types, "SimpleType"),
                name=quantity.type_name,
                description=quantity.description,
            )
            if quantity.unit:
                SubElement(simple, "Real", self.unit_attributes(quantity))
            else:
                named = {"quantity": quantity.type_name}
                self.add_items(SubElement(simple, "Enumeration", named))
        self.add_log_categories(root)
        self.add_experiment(root)
        variables = SubElement(root, "ModelVariables")
        for variable in self.variables:
            scalar = SubElement(variables, "ScalarVariable", self.general(variable))
            SubElement(scalar, _TYPE_TAGS[2][variable.type], self.typed(variable))
        self._add_structure(root)
        return root

    def _add_structure(self, root: Element) -> None:
        structure = SubElement(root, "ModelStructure")
        outputs = SubElement(structure, "Outputs")
        for variable, needs in self.outputs():
            SubElement(outputs, "Unknown", self.unknown(variable, needs, "index"))
        derivatives = SubElement(structure, "Derivatives")
        for variable in self.derivatives():
            SubElement(derivatives, "Unknown", self.unknown(variable, variable.needs, "index"))
        initial = SubElement(structure, "InitialUnknowns")
        for variable, needs in self.initial_unknowns():
            SubElement(initial, "Unknown", self.unknown(variable, needs, "index"))


class _Fmi3(_Writer):
    fmi: FmiVersion = 3

    def reference(self, name: str) -> str:
        return str(self.index[name])

    def root(self) -> Element:
        given = self.description
        version = {"fmiVersion": "3.0", "instantiationToken": given.token}
        root = Element("fmiModelDescription", version | self.attributes())
        common = {
            "modelIdentifier": MODEL_IDENTIFIER,
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
            "providesDirectionalDerivatives": self.differentiable(),
        }
        SubElement(root, "ModelExchange", common)
        SubElement(root, "CoSimulation", common, canHandleVariableCommunicationStepSize="true")
        self.add_units(root)
        types = SubElement(root, "TypeDefinitions")
        for quantity in self.quantities():
            named = {"name": quantity.type_name, "description": quantity.description}
            if quantity.unit:
                SubElement(types, "Float64Type", named | self.unit_attributes(quantity))
            else:
                named["quantity"] = quantity.type_name
                self.add_items(SubElement(types, "EnumerationType", named))
        self.add_log_categories(root)
        self.add_experiment(root)
        variables = SubElement(root, "ModelVariables")
        for variable in self.variables:
            tag = _TYPE_TAGS[3][variable.type]
            SubElement(variables, tag, self.general(variable) | self.typed(variable))
        structure = SubElement(root, "ModelStructure")
        key = "valueReference"
        for variable, needs in self.outputs():
            SubElement(structure, "Output", self.unknown(variable, needs, key))
        for variable in self.derivatives():
            attributes = self.unknown(variable, variable.needs, key)
            SubElement(structure, "ContinuousStateDerivative", attributes)
        for variable, needs in self.initial_unknowns():
            SubElement(structure, "InitialUnknown", self.unknown(variable, needs, key))
        return root
