"""What the contact DOFs of a law are, in words."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from slipmode.rom.laws.contacts import Contacts
from slipmode.rom.laws.friction import Coulomb, Friction, Tanh
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.joint_laws import Iwan, Jenkins, Sliders

_LAW_NAMES: dict[type[Any], str] = {
    Tanh: "tanh",
    Coulomb: "exact Coulomb",
    Jenkins: "Jenkins",
    Iwan: "Iwan",
    Sliders: "sliders in parallel",
    FrictionalContact: "frictional contact",
}
_UNITS = {
    **dict.fromkeys(("limit", "preload", "force"), " N"),
    **dict.fromkeys(("stiffness", "tangential_stiffness", "normal_stiffness"), " N/m"),
    **{"gap": " m", "alpha": " m/s"},
}
_MOST_VALUES = 8  # of one parameter


@dataclass(frozen=True)
class ContactDirection:
    """What a contact DOF is.

    Attributes
    ----------
    law : str
        Name of the contact law.
    normal : bool
        Whether it is a normal direction, positive where the contact closes.
    tangent : int
        Which of a contact's two tangential directions it is, 1 or 2; 0 where there is one.
    """

    law: str
    normal: bool = False
    tangent: int = 0

    @property
    def words(self) -> str:
        """The direction: "tangential", "second tangential", "normal"."""
        if self.normal:
            return "normal"
        return ("", "first ", "second ")[self.tangent] + "tangential"


def contact_directions(law: Friction, contacts: int) -> list[ContactDirection]:
    """Of each of so many contact DOFs."""
    found = {}
    for each, columns in _groups(law, contacts):
        name = _LAW_NAMES[type(each)]
        for place, column in enumerate(columns):
            found[column] = ContactDirection(name)
            if isinstance(each, FrictionalContact):
                k = place % (each.tangents + 1)
                tangent = k + 1 if each.tangents == 2 and k < 2 else 0
                found[column] = ContactDirection(name, k == each.tangents, tangent)
    return [found[column] for column in range(contacts)]


def law_words(law: Friction, contacts: int) -> list[str]:
    """Each law and its parameters, with the contact DOFs that it is on."""
    return [
        f"{_LAW_NAMES[type(each)]} ({_parameters(each)}) at contact DOFs {_ranges(columns)}"
        for each, columns in _groups(law, contacts)
    ]


def _groups(law: Friction, contacts: int) -> list[tuple[Any, list[int]]]:
    if isinstance(law, Contacts):
        return [(each, list(columns)) for each, columns in law.groups]
    return [(law, list(range(contacts)))]


def _parameters(law: Any) -> str:
    return ", ".join(
        f"{field.name.replace('_', ' ')} {_values(getattr(law, field.name))}"
        f"{_UNITS.get(field.name, '')}"
        for field in fields(law)
    )


def _values(value: Any) -> str:
    different = list(dict.fromkeys(np.atleast_1d(value).tolist()))
    if len(different) > _MOST_VALUES:
        return f"{min(different):g} to {max(different):g}"
    return " | ".join(f"{number:g}" for number in different)


def _ranges(columns: list[int]) -> str:
    """Numbers as ranges: "0-2, 5"."""
    parts: list[list[int]] = []
    for column in sorted(columns):
        if parts and column == parts[-1][1] + 1:
            parts[-1][1] = column
        else:
            parts.append([column, column])
    return ", ".join(f"{a}" if a == b else f"{a}-{b}" for a, b in parts)
