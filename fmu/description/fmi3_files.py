"""Further XML files of FMI 3.0: terminalsAndIcons.xml and sources/buildDescription.xml."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.description import MODEL_IDENTIFIER
from slipmode.fmu.description.model_description import to_bytes
from slipmode.fmu.variables.variable import Variable


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
        SubElement(
            made[name],
            "TerminalMemberVariable",
            variableName=variable.name,
            memberName=member,
            variableKind="signal",
        )
    return to_bytes(root)


def _terminal(name: str) -> tuple[str, str, str]:
    """Return the terminal of a variable, its description, and the name there; else ""."""
    if force := re.fullmatch(r"((?:force|frequency|phase)(?:_rate)?)_([AB])", name):
        member, mode = force.groups()
        return f"excitation_{mode}", f"Force on mode {mode}, its frequency and phase", member
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
