"""Contact laws as plain records: what model files store, and scenes say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Contacts, ElasticLaw
from slipmode.rom.laws.friction import Coulomb, Friction, Tanh
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.joint_laws import Iwan, Jenkins, Sliders

LAWS: dict[str, type[Any]] = {
    "tanh": Tanh,
    "coulomb": Coulomb,
    "jenkins": Jenkins,
    "iwan": Iwan,
    "sliders": Sliders,
    "frictional": FrictionalContact,
}
_GROUPS = "groups"


def record_of(law: Friction) -> dict[str, Any]:
    """The law's name and parameters, for JSON."""
    if isinstance(law, Contacts):
        return {
            "law": _GROUPS,
            "groups": [[record_of(each), list(columns)] for each, columns in law.groups],
        }
    name = next(name for name, kind in LAWS.items() if type(law) is kind)
    values = {field.name: getattr(law, field.name) for field in fields(law)}
    plain = {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}
    return {"law": name} | plain


def _group(record: Any, columns: Any) -> tuple[ElasticLaw, Any]:
    law = law_of(record)
    if not isinstance(law, ElasticLaw):
        raise SlipmodeError(f"law: {record['law']} is rigid, and has no place in a group")
    return law, columns


def law_of(record: Any) -> Friction:
    """The law that a record is of.

    Raises
    ------
    SlipmodeError
        If there is no such law, or a parameter is missing, unknown or refused.
    """
    if not isinstance(record, Mapping):
        raise SlipmodeError("law: is no such entry of a model")
    values = dict(record)
    name = values.pop("law", None)
    try:
        if name == _GROUPS:
            return Contacts([_group(*group) for group in values["groups"]])
        return LAWS[name](**values)  # type: ignore[no-any-return]
    except (KeyError, TypeError, ValueError):
        raise SlipmodeError("law: is no such entry of a model") from None
