"""The structure of a scene: two masses, matrices from files, or a bladed disk of equal sectors."""

from __future__ import annotations

import inspect
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from slipmode.rom import CyclicStructure, lumped_disk, random_mistuning
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.damping import Rayleigh
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.structure import Structure, load_structure, two_mass
from slipmode.runner.scene.toml_table import Table

_TWO_MASS_KEYS = set(inspect.signature(two_mass).parameters) - {"beta"}
# All sectors are solved together: 800 cycles of 200 sectors take 90 s. Real disks have fewer.
_MOST_MISTUNED = 200
_NAME_KEYS = ("mass_name", "stiffness_name", "damping_name")
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
    """The disk of `rom.lumped_disk`."""

    sectors: int = inspect.signature(lumped_disk).parameters["sectors"].default
    beta: float = inspect.signature(lumped_disk).parameters["beta"].default
    blade_stiffnesses: tuple[float, float] = (
        inspect.signature(lumped_disk).parameters["blade_stiffnesses"].default
    )

    def build(self) -> Disk:
        """Make the disk."""
        stiffnesses = self.blade_stiffnesses
        return Disk(lumped_disk(self.sectors, self.beta, blade_stiffnesses=stiffnesses))


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


def existing(table: Table, key: str, folder: Path) -> Path:
    """Return the path that a key names, relative to a folder; refuse one that does not exist."""
    path = folder / str(table[key])
    if not os.path.exists(path):  # noqa: PTH110  # Path.exists raises for impossible names
        raise table.error(key, f"no such file or folder: {str(path)!r}")
    return path


def read_structure(table: Table, folder: Path) -> TwoMass | MatrixFile | LumpedDisk | SectorFile:
    """Read the section [structure]; file names in it are relative to `folder`."""
    table.exactly_one(("model", "matrices"), "model", "give exactly one of model and matrices")
    values, model = table.values(), table["model"]
    for key in table:
        if model != "two-mass" and key in _TWO_MASS_KEYS:
            of = "matrices" if model is None else f'model = "{model}"'
            raise table.error(key, f'is a parameter of model = "two-mass", not of {of}')
        if model is not None and key in ("mass", "contacts", "rayleigh", *_NAME_KEYS):
            raise table.error(key, f'must be left out with model = "{model}"; it is for matrices')
        if key == "blade_stiffnesses" and model != "lumped-disk":
            raise table.error(key, 'must be left out; it is for model = "lumped-disk"')
        if key in _SECTOR_KEYS and (model is not None or "sectors" not in table):
            raise table.error(key, "needs matrices of one sector, and sectors")
    if model == "two-mass" and "sectors" in table:
        reason = 'must be left out; it is for model = "lumped-disk" or matrices of one sector'
        raise table.error("sectors", reason)
    damping = table["damping"]
    if model is not None:
        own = (*_TWO_MASS_KEYS, "sectors", "blade_stiffnesses")
        given = {key: values[key] for key in table if key in own}
        given |= {} if damping is None else {"beta": damping}
        return TwoMass(given) if model == "two-mass" else LumpedDisk(**given)
    matrices, mass = existing(table, "matrices", folder), None
    if "rayleigh" in table:
        if damping is not None:
            raise table.error("rayleigh", "give one of damping and rayleigh")
        damping = Rayleigh(*table["rayleigh"])
    if "mass" in table:
        mass = existing(table, "mass", folder)
    names = {key.removesuffix("_name"): table[key] for key in _NAME_KEYS if key in table}
    file = MatrixFile(matrices, damping, mass, table["contacts"], names or None)
    if "sectors" not in table:
        return file
    if "interface" in table and ("left" in table or "right" in table):
        raise table.error("interface", "give either left and right, or interface")
    return SectorFile(file, values["sectors"], **{k: values[k] or () for k in _SECTOR_KEYS})


def read_mistuning(table: Table, sectors: int) -> tuple[float, ...]:
    """Return the relative stiffness deviations of the blades, given or random, (N,)."""
    if sectors > _MOST_MISTUNED:
        raise SlipmodeError(
            f"structure.sectors: must be at most {_MOST_MISTUNED} with [mistuning], got {sectors}"
        )
    table.exactly_one(
        ("deviation", "standard_deviation"),
        "deviation",
        "give exactly one of deviation and standard_deviation",
    )
    given: tuple[float, ...] | None = table["deviation"]
    if given is None:
        (drawn,) = random_mistuning(1, sectors, table["standard_deviation"], seed=table["seed"])
        return tuple(drawn.tolist())
    if "seed" in table:
        raise table.error("seed", "needs standard_deviation, which is missing")
    if len(given) != sectors:
        raise table.error("deviation", f"must be {sectors} numbers, one per sector")
    return given
