"""terminalsAndIcons.xml of FMI 3.0: what belongs together, by force and by contact."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from slipmode.fmu.description.xml_writer import to_bytes
from slipmode.fmu.variables.variable import Variable

_FORCE = re.compile(r"(force|frequency|phase)(_rate)?_(?P<mode>[AB])")
_CONTACT = re.compile(r"contact_(?P<dof>\d+)_[xvf]")
_SIZE = 100.0  # of the icon's coordinates


def terminals_xml(variables: Sequence[Variable]) -> bytes:
    """The document: a terminal for the force on each mode, and for each contact DOF."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphics = SubElement(root, "GraphicalRepresentation")
    corners = {"x1": str(-_SIZE), "y1": str(-_SIZE), "x2": str(_SIZE), "y2": str(_SIZE)}
    SubElement(graphics, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    SubElement(graphics, "Icon", corners)
    terminals = SubElement(root, "Terminals")
    made: dict[str, Element] = {}
    for variable in variables:
        if force := _FORCE.fullmatch(variable.name):
            mode = force["mode"]
            name, member = f"excitation_{mode}", variable.name.removesuffix(f"_{mode}")
            words = f"Force on mode {mode}, its frequency and phase"
        elif contact := _CONTACT.fullmatch(variable.name):
            name, member = f"contact_{contact['dof']}", variable.name[-1]
            words = f"Motion and force at contact DOF {contact['dof']}"
        else:
            continue
        if name not in made:
            made[name] = SubElement(
                terminals, "Terminal", name=name, matchingRule="bus", description=words
            )
        SubElement(
            made[name],
            "TerminalMemberVariable",
            variableName=variable.name,
            memberName=member,
            variableKind="signal",
        )
    return to_bytes(root)
