"""Contact laws as plain records, for model files and scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Contacts
from slipmode.rom.laws.friction import Coulomb, Friction, Tanh
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.joint_laws import Iwan, Jenkins, Sliders
from slipmode.rom.laws.no_contacts import NoContacts

LAWS: dict[str, type[Any]] = {
    "tanh": Tanh,
    "coulomb": Coulomb,
    "jenkins": Jenkins,
    "iwan": Iwan,
    "sliders": Sliders,
    "frictional": FrictionalContact,
}
_NO_CONTACTS = {"law": "none"}  # only of model files


def record_of(law: Friction) -> dict[str, Any]:
    """Return the name and the parameters of a law, for JSON."""
    if isinstance(law, Contacts):
        return {
            "law": "groups",
            "groups": [[record_of(each), list(columns)] for each, columns in law.groups],
        }
    if isinstance(law, NoContacts):
        return dict(_NO_CONTACTS)
    name = next(name for name, kind in LAWS.items() if type(law) is kind)
    values = {field.name: getattr(law, field.name) for field in fields(law)}
    plain = {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}
    return {"law": name} | plain


def law_of(record: Any) -> Friction:
    """Return the law of a record; refuse one with missing, unknown or wrong parameters."""
    if record == _NO_CONTACTS:
        return NoContacts()
    if not (isinstance(record, Mapping) and record.get("law") == "groups"):
        single: Friction = _single_law(record)
        return single
    groups = record.get("groups")
    if set(record) != {"law", "groups"} or not isinstance(groups, list):
        raise SlipmodeError("law: must have a list of groups, and no other entries")
    made: Contacts = _made(Contacts, [_group(group) for group in groups])
    return made


def _group(group: Any) -> tuple[Any, list[int]]:
    if not (isinstance(group, list) and len(group) == 2 and isinstance(group[1], list)):
        raise SlipmodeError("law: a group must be a law and its contact DOFs")
    law, columns = _single_law(group[0]), group[1]
    if isinstance(law, Tanh | Coulomb):
        raise SlipmodeError("law: a group must be of elastic contacts")
    if not all(type(column) is int for column in columns):
        raise SlipmodeError("law: the contact DOFs of a group must be integers")
    return law, columns


def _single_law(record: Any) -> Any:
    name = record.get("law") if isinstance(record, Mapping) else None
    if not (isinstance(name, str) and name in LAWS):
        raise SlipmodeError(f"law: must be one of {', '.join(LAWS)} or groups")
    kind, values = LAWS[name], {key: value for key, value in record.items() if key != "law"}
    known = {field.name: field for field in fields(kind)}
    if unknown := sorted(set(values) - set(known)):
        raise SlipmodeError(f"law: {name} has no parameter {unknown[0]!r}")
    missing = [
        key for key, field in known.items() if field.default is MISSING and key not in values
    ]
    if missing:
        raise SlipmodeError(f"law: {name} needs {missing[0]}")
    for key, value in values.items():
        if not _is_parameter(value, known[key]):
            raise SlipmodeError(f"law: {key} of {name} has a wrong type")
    return _made(kind, **values)


def _is_parameter(value: Any, field: Field[Any]) -> bool:
    """Return whether a value has the type of the field: int, float or a list of numbers."""
    words = str(field.type)
    if words == "int":
        return type(value) is int
    if isinstance(value, list) and "Sequence" in words:
        return all(type(entry) in (int, float) for entry in value)
    return "float" in words.split(" | ") and type(value) in (int, float)


def _made(kind: type[Any], *values: Any, **named: Any) -> Any:
    try:
        return kind(*values, **named)
    except SlipmodeError as error:
        raise SlipmodeError(f"law: {error}") from None
    except OverflowError:
        raise SlipmodeError("law: a parameter is too large") from None
