"""The contacts of a scene: [friction] if rigid, [[contacts]] if elastic, [preload] on these."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np

from slipmode.rom import Contacts, Coulomb, Friction, FrictionalContact, Structure, Tanh
from slipmode.rom.contact.static_preload import Preload
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic, ElasticLaw
from slipmode.rom.laws.friction import is_homogeneous, limits
from slipmode.rom.laws.law_record import LAWS
from slipmode.runner.scene.kept import kept_preload
from slipmode.runner.scene.sections import ContactGroup, RigidFriction, Scene, StaticForce
from slipmode.runner.scene.toml_table import FINITE, NON_NEGATIVE, POSITIVE, Table

_RIGID = ("tanh", "coulomb")
ELASTIC = {name: kind for name, kind in LAWS.items() if name not in _RIGID}
_PARAMETERS = {name: [f.name for f in fields(kind)] for name, kind in ELASTIC.items()}
CONTACTS = (
    "law",
    "contacts",
    *dict.fromkeys(key for keys in _PARAMETERS.values() for key in keys),
)
FRICTION = ("law", "limit", "alpha")
PRELOAD = ("dof", "force", "vector")
STAND_IN = 'law = "jenkins" with a stiffness far above that of the structure stands for Coulomb'

_KINDS: Mapping[tuple[str, str], Callable[[Table, str], Any]] = {
    ("sliders", "limit"): lambda table, key: table.numbers(key, NON_NEGATIVE),
    ("sliders", "stiffness"): lambda table, key: table.numbers(key, POSITIVE),
    ("iwan", "force"): lambda table, key: table.number(key, POSITIVE),
    ("iwan", "stiffness"): lambda table, key: table.number(key, POSITIVE),
    ("iwan", "chi"): lambda table, key: table.number(key, FINITE),
    ("iwan", "beta"): lambda table, key: table.number(key, NON_NEGATIVE),
    ("iwan", "sliders"): lambda table, key: table.integer(key),
    ("frictional", "tangents"): lambda table, key: table.integer(key),
}
_STIFF = ("stiffness", "tangential_stiffness", "normal_stiffness")


def read_friction(table: Table) -> RigidFriction:
    """The section [friction]."""
    if table.is_one_of("law", tuple(ELASTIC)):
        raise table.error("law", "is an elastic law: use a group [[contacts]] instead")
    law = cast(Literal["tanh", "coulomb"], table.choice("law", _RIGID))
    if law == "coulomb" and "alpha" in table:
        raise table.error("alpha", 'goes with law = "tanh"; "coulomb" is not regularised')
    return RigidFriction(
        law=law,
        limit=table.number_or_numbers("limit", NON_NEGATIVE),
        alpha=table.number("alpha", POSITIVE) if law == "tanh" else None,
    )


def read_contacts(tables: list[Table]) -> tuple[ContactGroup, ...]:
    """The groups [[contacts]]."""
    groups = tuple(_group(table) for table in tables)
    for table, group in zip(tables, groups, strict=True):
        if group.contacts is None and len(groups) > 1:
            raise table.error(
                "contacts", "is missing: of several groups each says which contact DOFs it has"
            )
    return groups


def _group(table: Table) -> ContactGroup:
    if table.is_one_of("law", _RIGID):
        raise table.error("law", f"is a rigid law and goes in [friction], alone; {STAND_IN}")
    name = table.choice("law", tuple(ELASTIC))
    own = _PARAMETERS[name]
    for key in CONTACTS[2:]:
        if key in table and key not in own:
            raise table.error(key, f'is no parameter of law = "{name}"; it has {", ".join(own)}')
    values = {}
    for field in fields(ELASTIC[name]):
        if field.name in table or field.default is MISSING:
            values[field.name] = _parameter(table, name, field.name)
    try:
        law = ELASTIC[name](**values)
    except SlipmodeError as refusal:
        raise table.below(refusal) from None
    return ContactGroup(law, table.integers("contacts") if "contacts" in table else None)


def read_preload(
    table: Table, groups: tuple[ContactGroup, ...], file: Callable[[Table, str], Path]
) -> StaticForce:
    """The section [preload]; `file` finds the file that a key names."""
    if not any(isinstance(group.law, FrictionalContact) for group in groups):
        raise SlipmodeError(
            "preload: presses contacts together, and these have no normal direction; use a group "
            '[[contacts]] with law = "frictional", or leave it out'
        )
    if ("dof" in table) == ("vector" in table):
        raise table.error("dof", "give exactly one of dof and vector")
    if "vector" in table:
        if "force" in table:
            raise table.error("force", "goes with dof; vector has the forces")
        return StaticForce(
            file(table, "vector") if table.is_text("vector") else table.numbers("vector")
        )
    dof, force = table.integer_or_integers("dof"), table.number_or_numbers("force")
    dofs = dof if isinstance(dof, tuple) else (dof,)
    forces = force if isinstance(force, tuple) else (force,) * len(dofs)
    if not dofs or len(set(dofs)) < len(dofs):
        raise table.error("dof", "must be one DOF or several different ones")
    if len(forces) != len(dofs):
        raise table.error("force", f"must be one number or {len(dofs)} numbers (one per DOF)")
    return StaticForce(dict(zip(dofs, forces, strict=True)))


def _parameter(table: Table, law: str, key: str) -> Any:
    read = _KINDS.get((law, key))
    if read is not None:
        return read(table, key)
    return table.number_or_numbers(key, POSITIVE if key in _STIFF else NON_NEGATIVE)


def law_of(scene: Scene, contacts: int) -> Friction:
    """The law of a scene at so many contact DOFs.

    Raises
    ------
    SlipmodeError
        If numbers of parameters or of contact DOFs do not fit, naming the key.
    """
    if scene.friction is not None:
        return _rigid(scene.friction, contacts)
    for number, group in enumerate(scene.contacts):
        try:
            group.law.elements(contacts if group.contacts is None else len(group.contacts))
        except SlipmodeError as refusal:
            told = str(refusal).replace("contact:", "contacts:", 1)  # columns of W, in Python
            raise SlipmodeError(f"contacts[{number}].{told}") from None
    first = scene.contacts[0]
    if first.contacts is None:
        return first.law
    law = Contacts([(group.law, group.contacts or ()) for group in scene.contacts])
    law.elements(contacts)
    return law


def _rigid(friction: RigidFriction, contacts: int) -> Friction:
    law = (
        Coulomb(friction.limit) if friction.alpha is None else Tanh(friction.limit, friction.alpha)
    )
    try:
        limits(law, contacts)
    except SlipmodeError as error:
        raise SlipmodeError(f"friction.{error}") from None
    return law


def preloaded(scene: Scene, structure: Structure, law: Friction) -> Preload | None:
    """The state under the static force of a scene, if it has one.

    Raises
    ------
    SlipmodeError
        If it does not fit, or the contacts do not hold the structure under it.
    """
    if scene.preload is None:
        return None
    force = scene.preload.vector(structure.n_dofs)
    try:
        return kept_preload(structure, cast(Elastic, law), force)
    except SlipmodeError as refusal:
        raise SlipmodeError(str(refusal).replace("static_force:", "preload:", 1)) from None


def check_scale(scene: Scene, law: Friction, contacts: int) -> None:
    """Refuse a script of the limits where the motion does not scale with them.

    Raises
    ------
    SlipmodeError
        Naming the key and what stands against it.
    """
    if scene.limit_scale is None or is_homogeneous(law, contacts):
        return
    against, instead = "tanh has a velocity alpha", 'law = "coulomb"'
    if not isinstance(law, Tanh):
        gaps = [f"contacts[{k}].gap" for k, g in enumerate(scene.contacts) if _has_gap(g.law)]
        gap = gaps[0] if gaps else "the gap of contacts that [preload] opens"
        against, instead = f"{gap} is a length", "contacts without a gap"
    raise SlipmodeError(
        f"limits.scale: the motion has to scale with limits and preloads, and {against} that does "
        f"not; use {instead}, or a scene for each scale"
    )


def _has_gap(law: ElasticLaw) -> bool:
    return isinstance(law, FrictionalContact) and bool(np.any(np.asarray(law.gap) > 0.0))
