"""Keys of a scene's structure and contacts: the only declaration of their kind, unit, default.

The docstring of a table has the meaning of its keys. See keys.py.
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal

from slipmode.rom.laws.law_record import LAWS
from slipmode.rom.structure.structure import two_mass
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.toml_table import Role
from slipmode.runner.scene.values import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    OneOrEach,
    OneOrMore,
    at_least,
    between,
    choice,
    either,
    numbers,
    one_or_each,
    rows,
    text,
)

RIGID_LAWS = ("tanh", "coulomb")
ELASTIC_LAWS = {name: law for name, law in LAWS.items() if name not in RIGID_LAWS}
STAND_IN = (
    'law = "jenkins" with a stiffness far above the stiffness of the structure stands for Coulomb'
)
_RIGID = choice(
    *RIGID_LAWS,
    instead=dict.fromkeys(ELASTIC_LAWS, "is an elastic law; use a group [[contacts]] instead"),
)
_ELASTIC = choice(
    *ELASTIC_LAWS,
    instead=dict.fromkeys(RIGID_LAWS, f"is a rigid law and goes in [friction], alone; {STAND_IN}"),
)
_LAW: dict[str, Any] = {
    each.name: each.default for law in ELASTIC_LAWS.values() for each in fields(law)
}
_TWO_MASS = {name: each.default for name, each in inspect.signature(two_mass).parameters.items()}
_PAIRS = rows("[left node, right node]", (int, int))
_NEXT_CONTACTS = rows("[contact, node, direction]", (int, int, str))
_CONTACTS = rows("[node, direction] or [node, node, direction]", (int, str), (int, int, str))
_FORCES = either(text(), numbers(), "list of numbers, or string")


@dataclass(frozen=True)
class StructureTable:
    """The structure: the two-mass model, with the parameters from `contact_mass` on; matrices from
    files; or a bladed disk of equal sectors, whose modes are travelling waves.

    Attributes
    ----------
    model
        `rom.two_mass`, Table 1 of the source paper, or `rom.lumped_disk`. Give either `model` or
        `matrices`.
    matrices
        File or folder of matrices for `rom.load_structure`, relative to the scene. With `sectors`:
        matrices of one sector.
    damping
        Factor beta of C = beta K. Default: as in `rom.two_mass` or `rom.lumped_disk`; for matrices
        the damping in their files.
    sectors
        Number of sectors of a bladed disk, required for matrices of one sector. Default for the
        lumped disk: 24.
    blade_stiffnesses
        Stiffnesses of the lumped disk: between disk and first blade mass, and between the blade
        masses. Default: as in `rom.lumped_disk`.
    left
        DOFs on the left side of the sector. Other keys of the scene number all DOFs except
        `right`, from 0.
    right
        DOFs on the right side, in the order of the DOFs `left` of the next sector.
    interface
        Instead of `left` and `right`: pairs of nodes. The right node coincides with the left node
        of the next sector.
    next_contacts
        Node of the next sector that each contact touches. The contact displacement is relative to
        this node.
    mass
        File of the mass matrix, if the file `matrices` has the stiffness alone.
    mass_name
        Name of the mass matrix in a file with several matrices. Default: see `rom.load_structure`.
    stiffness_name
        Name of the stiffness matrix, likewise.
    damping_name
        Name of the damping matrix, likewise.
    contacts
        Contact DOFs by node; two nodes give a relative displacement. Default: contacts in the file
        of `matrices`.
    rayleigh
        [alpha, beta] of C = alpha M + beta K, instead of `damping`.
    loss_factor
        Loss factor eta of structural damping K (1 + i eta), instead of `damping`.
    contact_mass
        Mass of each contact DOF, > 0.
    m1
        First modal mass, > 0.
    m2
        Second modal mass, > 0.
    k1
        Stiffness between the first modal mass and its contact DOF.
    k2
        Stiffness between the second modal mass and its contact DOF.
    k_c1
        Stiffness between the first contact DOF and the ground.
    k_c2
        Stiffness between the second contact DOF and the ground.
    k_p
        Off-diagonal stiffness between the contact DOFs.
    """

    model: Literal["two-mass", "lumped-disk"] | None = None
    matrices: str | None = None
    damping: Annotated[float | None, NON_NEGATIVE, "s"] = None
    sectors: Annotated[int | None, at_least(3)] = None
    blade_stiffnesses: Annotated[tuple[float, float] | None, POSITIVE, "N/m"] = None
    left: tuple[int, ...] | None = None
    right: tuple[int, ...] | None = None
    interface: Annotated[tuple[tuple[int, int], ...] | None, _PAIRS] = None
    next_contacts: Annotated[tuple[tuple[int, int, str], ...] | None, _NEXT_CONTACTS] = None
    mass: str | None = None
    mass_name: str | None = None
    stiffness_name: str | None = None
    damping_name: str | None = None
    contacts: Annotated[tuple[tuple[int | str, ...], ...] | None, _CONTACTS] = None
    rayleigh: Annotated[tuple[float, float] | None, NON_NEGATIVE, "1/s, s"] = None
    loss_factor: Annotated[float | None, NON_NEGATIVE] = None
    contact_mass: Annotated[float, "kg"] = _TWO_MASS["contact_mass"]
    m1: Annotated[float, "kg"] = _TWO_MASS["m1"]
    m2: Annotated[float, "kg"] = _TWO_MASS["m2"]
    k1: Annotated[float, "N/m"] = _TWO_MASS["k1"]
    k2: Annotated[float, "N/m"] = _TWO_MASS["k2"]
    k_c1: Annotated[float, "N/m"] = _TWO_MASS["k_c1"]
    k_c2: Annotated[float, "N/m"] = _TWO_MASS["k_c2"]
    k_p: Annotated[float, "N/m"] = _TWO_MASS["k_p"]


@dataclass(frozen=True)
class MistuningTable:
    """Deviations of the blades of a disk. All nodal diameters respond to one engine order. The
    tables `[modes]` and `[model]` are not allowed. Only `slipmode run`, `plan`, `study` and
    `validate` accept such a scene.

    Attributes
    ----------
    deviation
        Relative stiffness deviation of each blade; for matrices, of each sector. Give either
        `deviation` or `standard_deviation`.
    standard_deviation
        Standard deviation of normally distributed deviations, see `rom.random_mistuning`.
    seed
        Seed of the random deviations.
    """

    deviation: Annotated[tuple[float, ...] | None, between(-0.9, 0.9)] = None
    standard_deviation: Annotated[float | None, between(1e-6, 0.2)] = None
    seed: int = 0


@dataclass(frozen=True)
class FrictionTable:
    """Rigid contacts with one law. A scene has either `[friction]` or groups `[[contacts]]`.

    Attributes
    ----------
    law
        Regularised Coulomb friction mu N tanh(v / alpha), or exact Coulomb friction.
    limit
        Friction limit mu N.
    alpha
        Regularisation velocity; required with `law = "tanh"`, not allowed with "coulomb".
    """

    law: Annotated[str, _RIGID]
    limit: Annotated[OneOrEach, NON_NEGATIVE, "N", Role.LIMIT]
    alpha: Annotated[float | None, POSITIVE, "m/s"] = None


@dataclass(frozen=True)
class ContactsTable:
    """Elastic contacts, in groups with one law each. The meaning of a parameter ends with the laws
    that have it. A law needs all its parameters except those with a default.

    Attributes
    ----------
    law
        Contact law of the group.
    contacts
        Contact DOFs of the group, from 0. Default for a single group: all contact DOFs.
    limit
        Friction limit mu N; a list for `sliders`. Laws: `jenkins`, `sliders`.
    stiffness
        Stiffness in stick; a list for `sliders`, one number for `iwan`. Laws: `jenkins`, `iwan`,
        `sliders`.
    force
        Force of macro-slip. Laws: `iwan`.
    chi
        Exponent of the slider density, -1 < chi <= 1. Laws: `iwan`.
    beta
        Stiffness of the sliders that slip at macro-slip, relative to all other sliders. Laws:
        `iwan`.
    sliders
        Number of sliders, 2 to 1000. Laws: `iwan`.
    mu
        Coefficient of friction. Laws: `frictional`.
    preload
        Normal force at rest. Laws: `frictional`.
    tangential_stiffness
        Tangential stiffness in stick. Laws: `frictional`.
    normal_stiffness
        Normal stiffness in contact. Laws: `frictional`.
    gap
        Normal displacement at which the contact touches; 0 for a contact with preload. Laws:
        `frictional`.
    tangents
        Number of tangential directions of each contact, 1 or 2. The normal DOF is the last. Laws:
        `frictional`.
    tangential_preload
        Tangential force at rest, at most `mu` times `preload`, one number or one per tangential
        direction of each contact. Laws: `frictional`.
    """

    law: Annotated[str, _ELASTIC]
    contacts: tuple[int, ...] | None = None
    limit: Annotated[OneOrEach | None, NON_NEGATIVE, "N", Role.LIMIT] = None
    stiffness: Annotated[OneOrEach | None, POSITIVE, "N/m"] = None
    force: Annotated[float | None, POSITIVE, "N", Role.LIMIT] = None
    chi: float | None = None
    beta: Annotated[float | None, NON_NEGATIVE] = None
    sliders: int = _LAW["sliders"]
    mu: Annotated[OneOrEach | None, NON_NEGATIVE] = None
    preload: Annotated[OneOrEach | None, NON_NEGATIVE, "N", Role.LIMIT] = None
    tangential_stiffness: Annotated[OneOrEach | None, POSITIVE, "N/m"] = None
    normal_stiffness: Annotated[OneOrEach | None, POSITIVE, "N/m"] = None
    gap: Annotated[OneOrEach, NON_NEGATIVE, "m"] = _LAW["gap"]
    tangents: int = _LAW["tangents"]
    tangential_preload: Annotated[OneOrEach, "N", Role.LIMIT] = _LAW["tangential_preload"]


@dataclass(frozen=True)
class PreloadTable:
    """A static force that presses frictional contacts together, or opens them, before the
    vibration starts. It acts in addition to the preloads of the contact law.

    Attributes
    ----------
    dof
        DOFs on which the force acts. Give either `dof` or `vector`.
    force
        Force at `dof`; required with it.
    vector
        Force on every DOF, or a .npy file with these forces.
    """

    dof: OneOrMore | None = None
    force: Annotated[OneOrEach | None, one_or_each(FINITE, "DOF"), "N"] = None
    vector: Annotated[str | tuple[float, ...] | None, _FORCES, "N"] = None


@dataclass(frozen=True)
class LimitsTable:
    """Friction limits and preloads over time. Not allowed with `tanh` or gaps.

    Attributes
    ----------
    scale
        Factor on all friction limits and preloads.
    wear
        Share of the limits and preloads that is lost per dissipated energy: they are
        `scale` (1 - `wear` E) after the contacts have dissipated the energy E. Of runs: curves,
        pages and FMUs have limits without wear.
    """

    scale: Annotated[Script | None, POSITIVE, Role.LOAD] = None
    wear: Annotated[float, NON_NEGATIVE, "1/J"] = 0.0
