"""modelDescription.xml and sources/buildDescription.xml of FMI 3.0."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.description import MODEL_IDENTIFIER
from slipmode.fmu.description.xml_writer import Writer, to_bytes
from slipmode.fmu.variables.variable import Causality, Type

_TAGS = {
    Type.REAL: "Float64",
    Type.ENUMERATION: "Enumeration",
    Type.BOOLEAN: "Boolean",
    Type.ARRAY: "Float64",
}


class Fmi3Writer(Writer):
    """Each type has elements of its own; the model structure has value references."""

    def _version(self) -> dict[str, str]:
        return {"fmiVersion": "3.0", "instantiationToken": self.description.token}

    def _reference(self, name: str) -> str:
        return str(self.index[name])

    def _add_interfaces(self, root: Element) -> None:
        common = {
            "modelIdentifier": MODEL_IDENTIFIER,
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
            "providesDirectionalDerivatives": "true",
            "providesAdjointDerivatives": "true",
        }
        SubElement(root, "ModelExchange", common)
        SubElement(
            root,
            "CoSimulation",
            common,
            canHandleVariableCommunicationStepSize="true",
            maxOutputDerivativeOrder="1",
            mightReturnEarlyFromDoStep="true",
            providesIntermediateUpdate="true",
            canReturnEarlyAfterIntermediateUpdate="true",
            hasEventMode="true",
        )

    def _add_types(self, types: Element) -> None:
        for quantity in self._quantities():
            named = {"name": quantity.type_name, "description": quantity.description}
            if quantity.unit:
                SubElement(types, "Float64Type", named | self._unit_attributes(quantity))
            else:
                named["quantity"] = quantity.type_name
                self._add_items(SubElement(types, "EnumerationType", named))

    def _add_variables(self, variables: Element) -> None:
        for variable in self.variables:
            attributes = self._general(variable) | self._typed(variable)
            if variable.causality is Causality.OUTPUT:
                attributes["intermediateUpdate"] = "true"
            element = SubElement(variables, _TAGS[variable.type], attributes)
            if variable.size is not None:
                SubElement(element, "Dimension", start=str(variable.size))

    def _add_structure(self, structure: Element) -> None:
        for tag, unknowns in (
            ("Output", self._outputs()),
            ("ContinuousStateDerivative", self._derivatives()),
            ("InitialUnknown", self._initial_unknowns()),
        ):
            for variable, needs in unknowns:
                SubElement(structure, tag, self._unknown(variable, needs, "valueReference"))


def build_description(sources: Sequence[str]) -> bytes:
    """sources/buildDescription.xml: how to build the library from C files in sources/."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=MODEL_IDENTIFIER)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(files, "IncludeDirectory", name=".")
    SubElement(configuration, "Library", name="m", description="libm, where it is one apart")
    return to_bytes(root)
