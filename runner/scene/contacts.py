"""The contacts of a scene: [friction] if rigid, [[contacts]] if elastic, [preload] on these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import cast

import numpy as np

from slipmode.rom import Contacts, Coulomb, Friction, FrictionalContact, Structure, Tanh
from slipmode.rom.contact.rest.static_preload import Preload
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import RigidFriction, is_homogeneous, limits
from slipmode.runner.scene.kept import kept_preload
from slipmode.runner.scene.sections import ContactGroup, Scene, StaticForce
from slipmode.runner.scene.structure_keys import (
    ELASTIC_LAWS,
    ContactsTable,
    FrictionTable,
    PreloadTable,
)
from slipmode.runner.scene.structures import existing
from slipmode.runner.scene.toml_table import Content, exactly_one, refuse_if, required
from slipmode.runner.scene.values import NON_NEGATIVE, POSITIVE, number, numbers

# Where a law takes fewer kinds of values than other laws with such a parameter
_KINDS = {
    ("sliders", "limit"): numbers(NON_NEGATIVE),
    ("sliders", "stiffness"): numbers(POSITIVE),
    ("iwan", "stiffness"): number(POSITIVE),
}


def read_friction(keys: FrictionTable) -> RigidFriction:
    """Read the section [friction]."""
    if keys.law == "tanh":
        return Tanh(keys.limit, required("friction.alpha", keys.alpha))
    without = 'friction.alpha: needs law = "tanh"; "coulomb" is not regularised'
    refuse_if(keys.alpha is not None, without)
    return Coulomb(keys.limit)


def read_contacts(tables: Sequence[ContactsTable], content: Content) -> tuple[ContactGroup, ...]:
    """Read the groups [[contacts]]."""
    for k, table in enumerate(tables):
        several = "is missing; each of several groups needs its contact DOFs"
        missing = table.contacts is None and len(tables) > 1
        refuse_if(missing, f"contacts[{k}].contacts: {several}")
    return tuple(
        _group(f"contacts[{k}]", table, content["contacts"][k]) for k, table in enumerate(tables)
    )


def _group(path: str, table: ContactsTable, given: Content) -> ContactGroup:
    law = ELASTIC_LAWS[table.law]
    own = {field.name: field.default for field in fields(law)}
    others = [key for key in given if key not in ("law", "contacts", *own)]
    reason = f'is not a parameter of law = "{table.law}"; it has {", ".join(own)}'
    refuse_if(bool(others), f"{path}.{''.join(others[:1])}: {reason}")
    for key, default in own.items():
        refuse_if(default is MISSING and key not in given, f"{path}.{key}: is missing")
        if (table.law, key) in _KINDS:
            _KINDS[table.law, key].read(f"{path}.{key}", given[key])
    try:
        return ContactGroup(law(**{key: getattr(table, key) for key in own}), table.contacts)
    except SlipmodeError as refusal:
        raise SlipmodeError(f"{path}.{refusal}") from None


def read_preload(keys: PreloadTable, groups: Sequence[ContactGroup], folder: Path) -> StaticForce:
    """Read the section [preload]; a file name in it is relative to `folder`."""
    if not any(isinstance(group.law, FrictionalContact) for group in groups):
        raise SlipmodeError(
            "preload: must be left out, because the contacts have no normal direction; or use a "
            'group [[contacts]] with law = "frictional"'
        )
    dof, vector = keys.dof, keys.vector
    exactly_one("preload.dof", (dof, vector), "give exactly one of dof and vector")
    if dof is None:
        reason = "preload.force: must be left out with vector, which has the forces"
        refuse_if(keys.force is not None, reason)
        if isinstance(vector, str):
            return StaticForce(existing("preload.vector", folder / vector))
        return StaticForce(vector or ())
    if keys.force is None:
        raise SlipmodeError("preload.force: is missing")
    force = keys.force
    dofs = dof if isinstance(dof, tuple) else (dof,)
    forces = force if isinstance(force, tuple) else (force,) * len(dofs)
    different = "preload.dof: must be one DOF or several different ones"
    refuse_if(not dofs or len(set(dofs)) < len(dofs), different)
    count = f"preload.force: must be one number or {len(dofs)} numbers (one per DOF)"
    refuse_if(len(forces) != len(dofs), count)
    return StaticForce(dict(zip(dofs, forces, strict=True)))


def law_of(scene: Scene, contacts: int) -> Friction:
    """Return the law of a scene at so many contact DOFs.

    Raises SlipmodeError, naming the key, if numbers of parameters or of contact DOFs do not fit.
    """
    if scene.friction is not None:
        try:
            limits(scene.friction, contacts)
        except SlipmodeError as error:
            raise SlipmodeError(f"friction.{error}") from None
        return scene.friction
    for k, group in enumerate(scene.contacts):
        try:
            group.law.elements(contacts if group.contacts is None else len(group.contacts))
        except SlipmodeError as refusal:
            # `contact` is the name in Python, where it means columns of W
            message = str(refusal).replace("contact:", "contacts:", 1)
            raise SlipmodeError(f"contacts[{k}].{message}") from None
    first = scene.contacts[0]
    if first.contacts is None:
        return first.law
    law = Contacts([(group.law, group.contacts or ()) for group in scene.contacts])
    law.elements(contacts)
    return law


def loaded_law(scene: Scene, structure: Structure) -> tuple[Friction, Preload | None]:
    """Return the law of a scene under its static force, and the state, None without a force.

    Raises SlipmodeError if the force does not fit, or the contacts do not hold the structure.
    """
    law = law_of(scene, structure.n_contacts)
    if scene.preload is None:
        return law, None
    force = scene.preload.vector(structure.n_dofs)
    try:
        rest = kept_preload(structure, cast(Elastic, law), force)
    except SlipmodeError as refusal:
        raise SlipmodeError(str(refusal).replace("static_force:", "preload:", 1)) from None
    return rest.law, rest


def check_scale(scene: Scene, law: Friction, contacts: int) -> None:
    """Refuse `[limits]` if the motion does not scale with limits and preloads."""
    if scene.limit_scale is None or is_homogeneous(law, contacts):
        return
    against, instead = "tanh has a velocity alpha", 'law = "coulomb"'
    if not isinstance(law, Tanh):
        gaps = [
            f"contacts[{k}].gap"
            for k, group in enumerate(scene.contacts)
            if isinstance(group.law, FrictionalContact) and np.any(np.asarray(group.law.gap) > 0.0)
        ]
        gap = gaps[0] if gaps else "the gap of contacts that [preload] opens"
        against, instead = f"{gap} is a length", "contacts without a gap"
    raise SlipmodeError(
        f"limits.{'wear' if scene.wear else 'scale'}: the motion must scale with limits and "
        f"preloads, but {against} that does not; use {instead}, or one scene per scale"
    )
