"""The structure of a scene: two masses, matrices from files, or a bladed disk of equal sectors."""

from __future__ import annotations

import inspect
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse

from slipmode.rom import CyclicStructure, lumped_disk, random_mistuning
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.damping import Rayleigh
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.structure import Structure, load_structure, two_mass
from slipmode.runner.scene.structure_keys import MistuningTable, StructureTable
from slipmode.runner.scene.toml_table import Content, exactly_one, refuse_given, refuse_if

_TWO_MASS_KEYS = [name for name in inspect.signature(two_mass).parameters if name != "beta"]
_DISK_SECTORS: int = inspect.signature(lumped_disk).parameters["sectors"].default
# All sectors are solved together: 800 cycles of 200 sectors take 90 s. Real disks have fewer.
_MOST_MISTUNED = 200
_NAME_KEYS = ("mass_name", "stiffness_name", "damping_name")
_MATRIX_KEYS = ("mass", "contacts", "rayleigh", *_NAME_KEYS)
_SECTOR_KEYS = ("left", "right", "interface", "next_contacts")


@dataclass(frozen=True)
class TwoMass:
    """The two-mass model, with the keyword arguments of `rom.two_mass` that are given."""

    parameters: Mapping[str, float]

    def build(self) -> Structure:
        """Make the structure."""
        return two_mass(**self.parameters)


@dataclass(frozen=True)
class MatrixFile:
    """Matrices on disk, as `rom.load_structure` reads them; other arguments override theirs."""

    path: Path
    damping: float | Rayleigh | None
    mass: Path | None = None
    contacts: tuple[tuple[int | str, ...], ...] | None = None
    names: Mapping[str, str] | None = None

    def build(self) -> Structure:
        """Load the structure."""
        return load_structure(
            self.path, self.damping, mass=self.mass, contact=self.contacts, names=self.names
        )


@frozen
class Disk:
    """A cyclic structure, with nodes and directions of the free DOFs of a sector if known."""

    structure: CyclicStructure
    labels: Labels | None = None


@dataclass(frozen=True)
class LumpedDisk:
    """The disk of `rom.lumped_disk`, with the keyword arguments that are given."""

    sectors: int
    parameters: Mapping[str, Any]

    def build(self) -> Disk:
        """Make the disk."""
        return Disk(lumped_disk(self.sectors, **self.parameters))


@dataclass(frozen=True)
class SectorFile:
    """Matrices of one sector on disk, and how it meets the next; see the keys of [structure]."""

    file: MatrixFile
    sectors: int
    left: tuple[int, ...] = ()
    right: tuple[int, ...] = ()
    interface: tuple[tuple[int, int], ...] = ()
    next_contacts: tuple[tuple[int, int, str], ...] = ()

    def build(self) -> Disk:
        """Load the sector and join it to the next."""
        sector, damping = self.file.build(), self.file.damping
        left, right = list(self.left), list(self.right)
        on_next = None
        if self.interface or self.next_contacts:
            if sector.labels is None:
                raise SlipmodeError(
                    "structure.interface, structure.next_contacts: the matrices have no nodes; "
                    "give left and right, or a model.file"
                )
            for pair in self.interface:
                for dofs, dof in zip((left, right), _joined(sector.labels, pair), strict=True):
                    dofs.extend(dof)
            on_next = self._next_directions(sector.labels, sector.n_contacts)
        with naming("structure"):
            disk = CyclicStructure(
                sector.mass,
                sector.stiffness,
                self.sectors,
                sector.damping if damping is None else damping,
                contact=sector.directions,
                next_contact=on_next,
                left=left,
                right=right,
            )
        free = disk.free_dofs
        labels = sector.labels and Labels(sector.labels.node[free], sector.labels.direction[free])
        return Disk(disk, labels)

    def _next_directions(self, labels: Labels, contacts: int) -> scipy.sparse.csc_array:
        """Return the directions on the next sector, (n, N_c); the motion is relative to these."""
        found = scipy.sparse.lil_array((labels.node.size, contacts))
        for contact, node, direction in self.next_contacts:
            if not 0 <= contact < contacts:
                raise SlipmodeError(
                    f"structure.next_contacts: contacts must be 0 to {contacts - 1}, got {contact}"
                )
            with naming("structure.next_contacts"):
                found[labels.dof(node, direction), contact] = -1.0
        return found.tocsc()


def _joined(labels: Labels, pair: tuple[int, int]) -> tuple[list[int], list[int]]:
    """Return the DOFs of two nodes in the directions that both have."""
    own = [
        dict(
            zip(
                labels.direction[labels.node == node],
                np.flatnonzero(labels.node == node),
                strict=True,
            )
        )
        for node in pair
    ]
    common = sorted(set(own[0]) & set(own[1]))
    if not common:
        raise SlipmodeError(
            f"structure.interface: nodes {pair[0]} and {pair[1]} have no direction in common"
        )
    left, right = ([int(dofs[k]) for k in common] for dofs in own)
    return left, right


def existing(key: str, path: Path) -> Path:
    """Return a path that a key names; refuse one that does not exist."""
    if not os.path.exists(path):  # noqa: PTH110  # Path.exists raises for impossible names
        raise SlipmodeError(f"{key}: no such file or folder: {str(path)!r}")
    return path


def read_structure(
    keys: StructureTable, content: Content, folder: Path
) -> TwoMass | MatrixFile | LumpedDisk | SectorFile:
    """Read the section [structure]; file names in it are relative to `folder`."""
    model, given = keys.model, content.get("structure", {})
    one = "give exactly one of model and matrices"
    exactly_one("structure.model", (model, keys.matrices), one)
    of = "matrices" if model is None else f'model = "{model}"'
    disk = 'must be left out; it is for model = "lumped-disk"'
    if model != "two-mass":
        of_two_mass = f'is a parameter of model = "two-mass", not of {of}'
        refuse_given(content, "structure", _TWO_MASS_KEYS, of_two_mass)
    else:
        refuse_given(content, "structure", ("sectors",), f"{disk} or matrices of one sector")
    if model != "lumped-disk":
        refuse_given(content, "structure", ("blade_stiffnesses",), disk)
    if model is not None:
        of_matrices = f"must be left out with {of}; it is for matrices"
        refuse_given(content, "structure", _MATRIX_KEYS, of_matrices)
    if model is not None or keys.sectors is None:
        of_sector = "needs matrices of one sector, and sectors"
        refuse_given(content, "structure", _SECTOR_KEYS, of_sector)
    damping: float | Rayleigh | None = keys.damping
    if keys.matrices is None:
        own = (*_TWO_MASS_KEYS, "blade_stiffnesses")
        parameters = {key: getattr(keys, key) for key in given if key in own}
        parameters |= {} if damping is None else {"beta": damping}
        if model == "two-mass":
            return TwoMass(parameters)
        return LumpedDisk(_DISK_SECTORS if keys.sectors is None else keys.sectors, parameters)
    matrices = existing("structure.matrices", folder / keys.matrices)
    if keys.rayleigh is not None:
        refuse_if(damping is not None, "structure.rayleigh: give one of damping and rayleigh")
        damping = Rayleigh(*keys.rayleigh)
    mass = None if keys.mass is None else existing("structure.mass", folder / keys.mass)
    named = {key.removesuffix("_name"): getattr(keys, key) for key in _NAME_KEYS if key in given}
    file = MatrixFile(matrices, damping, mass, keys.contacts, named or None)
    if keys.sectors is None:
        return file
    if keys.interface is not None:
        message = "structure.interface: give either left and right, or interface"
        refuse_if("left" in given or "right" in given, message)
    joined = {key: getattr(keys, key) or () for key in _SECTOR_KEYS}
    return SectorFile(file, keys.sectors, **joined)


def read_mistuning(keys: MistuningTable, content: Content, sectors: int) -> tuple[float, ...]:
    """Return the relative stiffness deviations of the blades, given or random, (N,)."""
    most = f"structure.sectors: must be at most {_MOST_MISTUNED} with [mistuning]"
    refuse_if(sectors > _MOST_MISTUNED, f"{most}, got {sectors}")
    one = "give exactly one of deviation and standard_deviation"
    exactly_one("mistuning.deviation", (keys.deviation, keys.standard_deviation), one)
    if keys.standard_deviation is not None:
        (drawn,) = random_mistuning(1, sectors, keys.standard_deviation, seed=keys.seed)
        return tuple(drawn.tolist())
    refuse_given(content, "mistuning", ("seed",), "needs standard_deviation, which is missing")
    given = keys.deviation or ()
    each = f"mistuning.deviation: must be {sectors} numbers, one per sector"
    refuse_if(len(given) != sectors, each)
    return given
