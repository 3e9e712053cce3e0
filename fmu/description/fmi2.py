"""modelDescription.xml of FMI 2.0."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.description import MODEL_IDENTIFIER
from slipmode.fmu.description.xml_writer import Writer
from slipmode.fmu.variables.variable import Type

_TAGS = {Type.REAL: "Real", Type.ENUMERATION: "Enumeration", Type.BOOLEAN: "Boolean"}


class Fmi2Writer(Writer):
    """Types are nested in types and variables; the model structure counts variables from 1."""

    def _version(self) -> dict[str, str]:
        return {"fmiVersion": "2.0", "guid": self.description.token}

    def _reference(self, name: str) -> str:
        return str(self.index[name] + 1)

    def _add_interfaces(self, root: Element) -> None:
        common = {
            "modelIdentifier": MODEL_IDENTIFIER,
            "canNotUseMemoryManagementFunctions": "true",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
            "providesDirectionalDerivative": "true",
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
            maxOutputDerivativeOrder="1",
        )
        for interface in (exchange, simulation):
            files = SubElement(interface, "SourceFiles")
            for name in self.description.sources:
                SubElement(files, "File", name=name)

    def _add_types(self, types: Element) -> None:
        for quantity in self._quantities():
            named = {"name": quantity.type_name, "description": quantity.description}
            simple = SubElement(types, "SimpleType", named)
            if quantity.unit:
                SubElement(simple, "Real", self._unit_attributes(quantity))
            else:
                self._add_items(SubElement(simple, "Enumeration", quantity=quantity.type_name))

    def _add_variables(self, variables: Element) -> None:
        for variable in self.variables:
            scalar = SubElement(variables, "ScalarVariable", self._general(variable))
            SubElement(scalar, _TAGS[variable.type], self._typed(variable))

    def _add_structure(self, structure: Element) -> None:
        for group, unknowns in (
            ("Outputs", self._outputs()),
            ("Derivatives", self._derivatives()),
            ("InitialUnknowns", self._initial_unknowns()),
        ):
            listed = SubElement(structure, group)
            for variable, needs in unknowns:
                SubElement(listed, "Unknown", self._unknown(variable, needs, "index"))
