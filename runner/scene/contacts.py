"""The contacts of a scene: [friction] if rigid, [[contacts]] if elastic, [preload] on these."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any, cast

import numpy as np

from slipmode.rom import Contacts, Coulomb, Friction, FrictionalContact, Structure, Tanh
from slipmode.rom.contact.static_preload import Preload
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import RigidFriction, is_homogeneous, limits
from slipmode.runner.scene.kept import kept_preload
from slipmode.runner.scene.keys import ELASTIC_LAWS, RIGID_LAWS
from slipmode.runner.scene.sections import ContactGroup, Scene, StaticForce
from slipmode.runner.scene.structures import existing
from slipmode.runner.scene.toml_table import Table
from slipmode.runner.scene.values import NON_NEGATIVE, POSITIVE, number, numbers

STAND_IN = (
    'law = "jenkins" with a stiffness far above the stiffness of the structure stands for Coulomb'
)


def read_friction(table: Table) -> RigidFriction:
    """Read the section [friction]."""
    if table.given("law") in tuple(ELASTIC_LAWS):
        raise table.error("law", "is an elastic law; use a group [[contacts]] instead")
    if table["law"] == "tanh":
        table.required("alpha")
    elif "alpha" in table:
        raise table.error("alpha", 'needs law = "tanh"; "coulomb" is not regularised')
    limit, alpha = table["limit"], table["alpha"]
    return Coulomb(limit) if alpha is None else Tanh(limit, alpha)


def read_contacts(tables: list[Table]) -> tuple[ContactGroup, ...]:
    """Read the groups [[contacts]]."""
    groups = tuple(_group(table) for table in tables)
    for table, group in zip(tables, groups, strict=True):
        if group.contacts is None and len(groups) > 1:
            raise table.error(
                "contacts", "is missing; each of several groups needs its contact DOFs"
            )
    return groups


def _group(table: Table) -> ContactGroup:
    if table.given("law") in RIGID_LAWS:
        raise table.error("law", f"is a rigid law and goes in [friction], alone; {STAND_IN}")
    name = table["law"]
    own = [field.name for field in fields(ELASTIC_LAWS[name])]
    for key in table:
        if key not in ("law", "contacts", *own):
            raise table.error(
                key, f'is not a parameter of law = "{name}"; it has {", ".join(own)}'
            )
    kinds = {  # where the law takes fewer kinds of values than other laws with such a parameter
        ("sliders", "limit"): numbers(NON_NEGATIVE),
        ("sliders", "stiffness"): numbers(POSITIVE),
        ("iwan", "stiffness"): number(POSITIVE),
    }
    parameters: dict[str, Any] = {key: table.read(key, kinds.get((name, key))) for key in own}
    try:
        law = ELASTIC_LAWS[name](**parameters)
    except SlipmodeError as refusal:
        raise table.below(refusal) from None
    return ContactGroup(law, table["contacts"])


def read_preload(table: Table, groups: tuple[ContactGroup, ...], folder: Path) -> StaticForce:
    """Read the section [preload]; a file name in it is relative to `folder`."""
    if not any(isinstance(group.law, FrictionalContact) for group in groups):
        raise SlipmodeError(
            "preload: must be left out, because the contacts have no normal direction; or use a "
            'group [[contacts]] with law = "frictional"'
        )
    table.exactly_one(("dof", "vector"), "dof", "give exactly one of dof and vector")
    if "vector" in table:
        if "force" in table:
            raise table.error("force", "must be left out with vector, which has the forces")
        vector = table["vector"]
        return StaticForce(existing(table, "vector", folder) if type(vector) is str else vector)
    dof, force = table["dof"], table.required("force")
    dofs = dof if isinstance(dof, tuple) else (dof,)
    forces = force if isinstance(force, tuple) else (force,) * len(dofs)
    if not dofs or len(set(dofs)) < len(dofs):
        raise table.error("dof", "must be one DOF or several different ones")
    if len(forces) != len(dofs):
        raise table.error("force", f"must be one number or {len(dofs)} numbers (one per DOF)")
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
    """Refuse `limits.scale` if the motion does not scale with limits and preloads."""
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
        f"limits.scale: the motion must scale with limits and preloads, but {against} that does "
        f"not; use {instead}, or one scene per scale"
    )
