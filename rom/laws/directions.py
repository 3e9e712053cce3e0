"""Contact DOFs of a law in words, and a check of their directions."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import combinations
from typing import Any

import numpy as np

from slipmode.rom.laws.contacts import Contacts
from slipmode.rom.laws.friction import Friction
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.law_record import LAWS
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.structure.matrices import Matrix, as_dense

_NAMES = ("tanh", "exact Coulomb", "Jenkins", "Iwan", "sliders in parallel", "frictional contact")
_LAW_NAMES = dict(zip(LAWS.values(), _NAMES, strict=True))
_UNITS = {
    **dict.fromkeys(("limit", "preload", "tangential_preload", "force"), " N"),
    **dict.fromkeys(("stiffness", "tangential_stiffness", "normal_stiffness"), " N/m"),
    **{"gap": " m", "alpha": " m/s"},
}
# Cosine of the angle between directions of a contact, and relative difference of their lengths.
_SKEWED = 0.01
_OF_ONE_CONTACT = (
    " (columns of W). Directions of one contact must be orthogonal and equally long, unless DOFs "
    "are rotations or modal coordinates"
)


@dataclass(frozen=True)
class ContactDirection:
    """Law and direction of a contact DOF."""

    law: str  # name of the contact law
    normal: bool = False  # whether it is a normal direction, positive as the contact closes
    tangent: int = 0  # number of the tangential direction, 1 or 2; 0 if the contact has one

    @property
    def words(self) -> str:
        """The direction: "tangential", "second tangential", "normal"."""
        if self.normal:
            return "normal"
        return ("", "first ", "second ")[self.tangent] + "tangential"


def contact_directions(law: Friction, contacts: int) -> list[ContactDirection]:
    """Return law and direction of each of `contacts` contact DOFs."""
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


def skewed_directions(W: Matrix, law: Friction) -> str:
    """Return in words which columns of W (n, N_c) of a contact are not orthogonal; "" if all are.

    Columns of one contact are B^T e with orthogonal unit vectors e, B being the relative
    displacement by all DOFs. If DOFs are translations, interpolated over a mesh or weighted by
    areas, B B^T is a multiple of the identity, and W^T W too. With rotations and modal coordinates
    it is not; a contact that every DOF moves is taken to be in modal coordinates.
    """
    gram = as_dense(W.T @ W)
    length = np.sqrt(np.diag(gram))
    for each, columns in _groups(law, len(gram)):
        if not isinstance(each, FrictionalContact):
            continue
        for first in range(0, len(columns), each.tangents + 1):
            own = columns[first : first + each.tangents + 1]
            if as_dense(W[:, own]).any(axis=1).all():
                continue
            for a, b in combinations(own, 2):
                cosine = gram[a, b] / (length[a] * length[b])
                if abs(cosine) > _SKEWED:
                    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
                    return f"contact DOFs {a} and {b} are at {angle:.0f} degrees{_OF_ONE_CONTACT}"
                if abs(length[b] / length[a] - 1.0) > _SKEWED:
                    lengths = f"{length[a]:.3g} and {length[b]:.3g} long"
                    return f"contact DOFs {a} and {b} are {lengths}{_OF_ONE_CONTACT}"
    return ""


def law_words(law: Friction, contacts: int) -> list[str]:
    """Return each law with its parameters and contact DOFs, in words."""
    return [
        f"{_LAW_NAMES[type(each)]} ({_parameters(each)}) at contact DOFs {_ranges(columns)}"
        for each, columns in _groups(law, contacts)
    ]


def _groups(law: Friction, contacts: int) -> list[tuple[Any, list[int]]]:
    if isinstance(law, Contacts):
        return [(each, list(columns)) for each, columns in law.groups]
    if isinstance(law, NoContacts):
        return []
    return [(law, list(range(contacts)))]


def _parameters(law: Any) -> str:
    return ", ".join(
        f"{field.name.replace('_', ' ')} {_values(getattr(law, field.name))}"
        f"{_UNITS.get(field.name, '')}"
        for field in fields(law)
    )


def _values(value: Any) -> str:
    different = list(dict.fromkeys(np.atleast_1d(value).tolist()))
    if len(different) > 8:  # so many values of a parameter are listed
        return f"{min(different):g} to {max(different):g}"
    return " | ".join(f"{number:g}" for number in different)


def _ranges(columns: list[int]) -> str:
    """Return numbers as ranges: "0-2, 5"."""
    parts: list[list[int]] = []
    for column in sorted(columns):
        if parts and column == parts[-1][1] + 1:
            parts[-1][1] = column
        else:
            parts.append([column, column])
    return ", ".join(f"{a}" if a == b else f"{a}-{b}" for a, b in parts)
