"""The structure of a scene: two masses, matrices from files, or a bladed disk of equal sectors.

A saved model (`model.file`) takes the place of a structure with contacts.
"""

from __future__ import annotations

import inspect
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import scipy

from slipmode.rom import CyclicStructure, Model, lumped_disk, random_mistuning
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.damping import LossFactor, Rayleigh
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.structure import Structure, load_structure, two_mass
from slipmode.runner.scene.keys import ModelOptions
from slipmode.runner.scene.structure_keys import MistuningTable, StructureTable
from slipmode.runner.scene.toml_table import Content, exactly_one, refuse_given, refuse_if

_TWO_MASS_KEYS = [name for name in inspect.signature(two_mass).parameters if name != "beta"]
_DISK = {name: each.default for name, each in inspect.signature(lumped_disk).parameters.items()}
# All sectors are solved together: 800 cycles of 200 sectors take 90 s. Real disks have fewer.
_MOST_MISTUNED = 200
_NAME_KEYS = ("mass_name", "stiffness_name", "damping_name")
_MATRIX_KEYS = ("mass", "contacts", "rayleigh", "loss_factor", *_NAME_KEYS)
_SECTOR_KEYS = ("left", "right", "interface", "next_contacts")


@frozen
class Disk:
    """A cyclic structure, with nodes and directions of the free DOFs of a sector if known."""

    structure: CyclicStructure
    labels: Labels | None = None


@dataclass(frozen=True)
class Source:
    """Where the matrices of a structure or of a sector are from: checked keys of [structure]."""

    keys: StructureTable
    folder: Path  # File names are relative to it

    @property
    def sectors(self) -> int:
        """Number of sectors of a bladed disk; 0 if the structure is none."""
        lumped = _DISK["sectors"] if self.keys.model == "lumped-disk" else 0
        return self.keys.sectors or lumped

    @property
    def _damping(self) -> float | Rayleigh | LossFactor | None:
        rayleigh = self.keys.rayleigh
        if self.keys.loss_factor is not None:
            return LossFactor(self.keys.loss_factor)
        return self.keys.damping if rayleigh is None else Rayleigh(*rayleigh)

    def build(self) -> Structure:
        """Make the structure; of a disk from files, one sector."""
        keys = self.keys
        if keys.model == "two-mass":
            beta = {} if keys.damping is None else {"beta": keys.damping}
            return two_mass(**{name: getattr(keys, name) for name in _TWO_MASS_KEYS}, **beta)
        names = {part: getattr(keys, f"{part}_name") for part in ("mass", "stiffness", "damping")}
        return load_structure(
            self.folder / str(keys.matrices),
            self._damping,
            mass=None if keys.mass is None else self.folder / keys.mass,
            contact=keys.contacts,
            names={part: name for part, name in names.items() if name is not None} or None,
        )

    def build_disk(self) -> Disk:
        """Make the disk: join a sector to the next."""
        keys = self.keys
        if keys.model is not None:
            beta = _DISK["beta"] if keys.damping is None else keys.damping
            stiffnesses = keys.blade_stiffnesses or _DISK["blade_stiffnesses"]
            return Disk(lumped_disk(self.sectors, beta, blade_stiffnesses=stiffnesses))
        sector, damping = self.build(), self._damping
        left, right = list(keys.left or ()), list(keys.right or ())
        on_next = None
        if keys.interface or keys.next_contacts:
            if sector.labels is None:
                raise SlipmodeError(
                    "structure.interface, structure.next_contacts: the matrices have no nodes; "
                    "give left and right, or a model.file"
                )
            for pair in keys.interface or ():
                for dofs, dof in zip((left, right), _joined(sector.labels, pair), strict=True):
                    dofs.extend(dof)
            on_next = self._next_directions(sector.labels, sector.n_contacts)
        with naming("structure"):
            if sector.loss is not None:
                raise SlipmodeError(
                    "loss_factor, matrices: bladed disks have no structural damping; give damping"
                )
            disk = CyclicStructure(
                sector.mass,
                sector.stiffness,
                self.sectors,
                damping if isinstance(damping, float | Rayleigh) else sector.damping,
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
        for contact, node, direction in self.keys.next_contacts or ():
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


def read_structure(keys: StructureTable, content: Content, folder: Path) -> Source:
    """Check the section [structure]; file names in it are relative to `folder`."""
    model = keys.model
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
    for key, name in (("matrices", keys.matrices), ("mass", keys.mass)):
        if name is not None:
            existing(f"structure.{key}", folder / name)
    if keys.damping is not None:
        one = "give one of damping, rayleigh and loss_factor"
        refuse_given(content, "structure", ("rayleigh", "loss_factor"), one)
    if keys.rayleigh is not None:
        one = "give one of rayleigh and loss_factor"
        refuse_given(content, "structure", ("loss_factor",), one)
    if (keys.left, keys.right) != (None, None):
        pairs = "give either left and right, or interface"
        refuse_given(content, "structure", ("interface",), pairs)
    return Source(keys, folder)


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


def read_saved_model(file: str | None, content: Content, folder: Path) -> Model | None:
    """Return the model that `model.file` names, or None without this key.

    Raises SlipmodeError if the file is refused, or the scene gives what the model has already or
    what it does not have.
    """
    if file is None:
        return None
    path = folder.absolute() / file
    try:
        stat = path.stat()
        with naming("model.file"):
            model = _loaded(path, stat.st_mtime_ns, stat.st_size)
    except OSError:
        raise SlipmodeError(f"model.file: no such model file: {str(path)!r}") from None
    its_own = "must be left out, because the model of model.file has its own"
    tables = ("structure", "friction", "contacts", "preload", "aerodynamics", "modes")
    refuse_given(content, "", ("nonlinear_stiffness",), its_own)
    refuse_given(content, "", tables, its_own)
    no_structure = "must be left out, because model.file has no structure for full order"
    refuse_given(content, "model", ("table", "transients"), no_structure)
    refuse_given(content, "model", [key for key in content["model"] if key != "file"], its_own)
    if not model.reduced.n_contacts:
        without = "must be left out, because the model of model.file has no contacts"
        refuse_given(content, "", ("limits",), without)
        refuse_given(content, "", ("contact",), f"{without}; [[elastic]] windows have its DOFs")
    return model


def options_of(model: Model) -> ModelOptions:
    """Return the [model] options that a saved model stands for; it stays in slow time."""
    return ModelOptions(
        tolerance=model.accuracy.tolerance,
        formulation=model.reduced.formulation,
        amplitude=tuple(model.table.amplitude_range.tolist()),
        table="whole",
        transients="slow",
    )


@lru_cache(maxsize=2)
def _loaded(path: Path, _time: int, _size: int) -> Model:
    """Return the model of a file in a certain state: scenes of a study often have the same one."""
    return Model.load(path)
