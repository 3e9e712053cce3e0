"""A scene in Python: each class is a section of the scene file, with values that were checked.

Times are in s, frequencies in rad/s, forces in N, displacements in m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.laws.contacts import ElasticLaw
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.reduction.reduced import force_vector
from slipmode.rom.slow.units import SI, Units
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.structure import Structure
from slipmode.rom.table.model import Model
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.structures import LumpedDisk, MatrixFile, SectorFile, TwoMass


@dataclass(frozen=True)
class NodeDof:
    """A DOF by its node and direction, "x", "y", "z", "rx", "ry" or "rz"."""

    node: int
    direction: str

    def dof(self, key: str, labels: Labels | None, source: str) -> int:
        """Return the number of the DOF; a refusal names the key, and the source of the labels."""
        if labels is None:
            raise SlipmodeError(f"{key}: {source} no nodes; give DOFs")
        with naming(key):
            return labels.dof(self.node, self.direction)


@dataclass(frozen=True)
class ContactGroup:
    """Elastic contacts with one law, and their contact DOFs; None: all contact DOFs."""

    law: ElasticLaw
    contacts: tuple[int, ...] | None


@dataclass(frozen=True)
class StaticForce:
    """A force at rest [N]: on some DOFs, on every DOF, or on every DOF from an .npy file."""

    force: Mapping[int, float] | tuple[float, ...] | Path

    def vector(self, n_dofs: int) -> Floats:
        """Return the force as an (n,) vector.

        Raises SlipmodeError if the number of DOFs is another one, or the file has no such force.
        """
        force: Any = self.force
        if isinstance(force, Path):
            try:
                force = np.asarray(np.load(force, allow_pickle=False), dtype=float)
            except (OSError, ValueError, TypeError, EOFError):
                raise SlipmodeError(
                    f"preload.vector: must be an .npy file of one number per DOF: {str(force)!r}"
                ) from None
        return _force_vector("preload", force, n_dofs)


def _force_vector(table: str, force: Mapping[int, float] | Sequence[float], n: int) -> Floats:
    """Return a force on some DOFs, or on every DOF, as an (n,) vector; refusals name the key."""
    if isinstance(force, Mapping):
        if max(force) >= n:
            raise SlipmodeError(f"{table}.dof: must be 0 to {n - 1}, got {max(force)}")
        return force_vector(force, n)
    given = np.array(force)
    if given.shape != (n,):
        shape = " x ".join(map(str, given.shape))
        raise SlipmodeError(f"{table}.vector: must have {n} numbers, one per DOF, got {shape}")
    return force_vector(given, n, f"{table}.vector")


@dataclass(frozen=True)
class Modes:
    """Numbers of the retained modes with stuck contacts, ascending from 0; B is optional.

    Of sectors they are counted for each nodal diameter.
    """

    A: int
    B: int | None = None
    nodal_diameters: tuple[int, ...] | None = None

    @property
    def numbers(self) -> dict[Mode, int]:
        """The number of mode "A", and of "B" if there is one."""
        return {"A": self.A} if self.B is None else {"A": self.A, "B": self.B}


@dataclass(frozen=True)
class Forcing:
    """The force `amplitude cos(theta + phase)` of a pattern, theta' = frequency.

    With an engine order the frequency follows from the rotor speed.
    """

    mode: str
    pattern: int | tuple[float, ...] | NodeDof
    amplitude: Script
    frequency: Script
    phase: Script
    engine_order: int | None = None

    def vector(self, n_dofs: int) -> Floats:
        """Return the pattern as an (n,) vector: a unit vector if it was given as a DOF.

        Raises SlipmodeError if the structure has no such DOF, or another number of them.
        """
        assert not isinstance(self.pattern, NodeDof)  # `Scene.located` has replaced nodes
        pattern = {self.pattern: 1.0} if isinstance(self.pattern, int) else self.pattern
        return _force_vector(f"forcing.{self.mode}", pattern, n_dofs)


@dataclass(frozen=True)
class Run:
    """From 0 to `duration` [s] in communication steps; relative tolerance of the slow flow."""

    duration: float
    step: float
    tolerance: float


@dataclass(frozen=True)
class ModelOptions:
    """How the reduced model is made; the keys of [model].

    `tolerance` is the relative tolerance of the friction table, `amplitude` its range per mode,
    None if the plan finds it.
    """

    tolerance: float
    formulation: Literal["consistent", "paper"]
    amplitude: tuple[float, ...] | None
    table: Literal["whole", "none"]
    transients: Literal["auto", "slow", "hybrid"] = "auto"
    budget: float | None = None

    @property
    def transient_error(self) -> float:
        """Largest estimated transient error that slow time may have, relative to the range."""
        return 1e-3 if self.transients == "hybrid" else max(self.tolerance, 1e-2)


@dataclass(frozen=True)
class Window:
    """A time window [s] in which fast motion is reconstructed."""

    start: float
    end: float
    samples_per_period: int


@dataclass(frozen=True)
class Output:
    """DOFs of the structure reconstructed inside the windows; `nodes` until they are located."""

    elastic: tuple[int, ...]
    nodes: tuple[NodeDof, ...] = ()


@dataclass(frozen=True)
class Log:
    """Which recordings are written."""

    mcap: bool
    rerun: bool


@dataclass(frozen=True)
class Scene:
    """A scene, validated as far as it can be without building the structure.

    Attributes
    ----------
    title, text, path, name
        Title, TOML source, file (or None), and the file's name without its ending.
    structure, friction, contacts, preload
        Its matrices, or those of a sector; the law of rigid contacts, or None; groups of elastic
        contacts, or (); the force that presses contacts together, or opens them, at rest, or None.
    mistuning : tuple of float
        Relative stiffness deviation of each blade; () if they are equal.
    saved_model : Model or None
        A saved model instead of these; `structure` is None then.
    limit_scale : Script or None
        Factor on limits and preloads over time; None: they are constant.
    modes : Modes
    forcing, initial, aerodynamics : mapping of "A", "B"
        Forces, of forced modes only; modal amplitudes at t = 0, of modes that do not start from
        rest; aerodynamic influence coefficients [rad^2/s^2], see `rom.reduce`.
    run, model : Run, ModelOptions
    contact, elastic : tuple of Window
        Windows of contact motion, with the motion of the elastic DOFs, and of the elastic DOFs
        alone; in time order. No window overlaps another.
    output, log : Output, Log
    units : Units
        Units of frequencies in the file, and of pictures and tables. Frequencies here are in
        rad/s.
    """

    title: str
    structure: TwoMass | MatrixFile | LumpedDisk | SectorFile | None
    mistuning: tuple[float, ...]
    saved_model: Model | None
    friction: RigidFriction | None
    contacts: tuple[ContactGroup, ...]
    preload: StaticForce | None
    limit_scale: Script | None
    modes: Modes
    forcing: Mapping[str, Forcing]
    initial: Mapping[str, complex]
    aerodynamics: Mapping[str, complex]
    run: Run
    model: ModelOptions
    contact: tuple[Window, ...]
    elastic: tuple[Window, ...]
    output: Output
    log: Log
    text: str = field(repr=False)
    units: Units = SI
    path: Path | None = None
    name: str = "scene"

    def __repr__(self) -> str:
        return f"Scene({self.title!r}, {self.name}, {self.run.duration:g} s)"

    @property
    def disk(self) -> LumpedDisk | SectorFile | None:
        """The structure if it is a bladed disk, whose modes are travelling waves."""
        of_sectors = isinstance(self.structure, LumpedDisk | SectorFile)
        return self.structure if of_sectors else None  # type: ignore[return-value]

    @property
    def windows(self) -> list[Window]:
        """All windows, in time order."""
        return sorted((*self.contact, *self.elastic), key=lambda window: window.start)

    @property
    def tabulated(self) -> bool:
        """Whether the scene has a friction table over amplitudes of modes.

        Otherwise all of it is at full order, or its disk is mistuned.
        """
        return self.model.table != "none" and not self.mistuning

    @property
    def switches(self) -> bool:
        """Whether a run goes to full order where slow time has too large a transient error."""
        possible = self.tabulated and self.model.formulation == "consistent" and self.disk is None
        return possible and self.limit_scale is None and self.model.transients != "slow"

    def in_slow_time(self) -> Self:
        """Return the same scene without stretches at full order."""
        return replace(self, model=replace(self.model, transients="slow"))

    def check_tuned(self) -> None:
        """Refuse a mistuned disk."""
        if self.mistuning:
            raise SlipmodeError(
                "mistuning: this needs a model of one or two waves, and a mistuned disk responds "
                "in all its modes; leave [mistuning] out, or use rom.MistunedDisk. slipmode "
                "run, study, validate and plan (runner.plan_scene) take mistuned disks"
            )

    def check_tabulated(self) -> None:
        """Refuse a scene without a friction table."""
        self.check_tuned()
        if not self.tabulated:
            raise SlipmodeError(
                'model.table: "none" integrates runs of the scene, and this needs a friction '
                'table; give "whole"'
            )

    def build(self) -> Structure:
        """Build the structure; refuse a scene with a saved model, which has none."""
        if self.structure is None:
            raise SlipmodeError(
                "model.file: a saved model has no structure, and this needs one; give [structure] "
                "and its contacts instead"
            )
        if self.disk is not None:
            raise SlipmodeError(
                "structure.sectors: this needs a whole structure, and the scene has one sector; "
                "slipmode diameters has its modes, rom.CyclicStructure.annulus() all sectors"
            )
        return self.structure.build()  # type: ignore[return-value]

    def located(self, labels: Labels | None) -> Self:
        """Return the same scene with DOFs instead of nodes."""
        source = (
            "the matrices name" if self.saved_model is None else "the model of model.file names"
        )
        forcing = dict(self.forcing)
        for mode, each in forcing.items():
            if isinstance(each.pattern, NodeDof):
                dof = each.pattern.dof(f"forcing.{mode}", labels, source)
                forcing[mode] = replace(each, pattern=dof)
        dofs = self.output.elastic
        dofs += tuple(node.dof("output.nodes", labels, source) for node in self.output.nodes)
        if len(set(dofs)) < len(dofs):
            raise SlipmodeError("output.nodes: DOFs must be distinct, also from output.elastic")
        return replace(self, forcing=forcing, output=Output(dofs))
