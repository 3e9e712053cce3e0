"""A scene in Python, with values that were checked.

Times are in s, frequencies in rad/s, forces in N, displacements in m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.laws.contacts import ElasticLaw
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.slow.units import SI, Units
from slipmode.rom.storage.stored_arrays import read_npy
from slipmode.rom.structure.force_vector import force_vector
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.structure import Structure
from slipmode.rom.table.model import Model
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.keys import Log, ModelOptions, NodeDof, Output, Run, Window
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.structures import Source


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
                with force.open("rb") as file:
                    array = read_npy(file, force.stat().st_size)
                force = np.asarray(array, dtype=float)
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

    Of sectors they are counted for each nodal diameter. With a ratio, B is on the tone of A and
    has this multiple of its frequency. If several modes share a tone, `tones` has the numbers of
    those on each tone; A and B are the first of them.
    """

    A: int
    B: int | None = None
    ratio: Fraction | None = None
    nodal_diameters: tuple[int, ...] | None = None
    tones: tuple[tuple[int, ...], ...] = ()

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
    quadrature: int | tuple[float, ...] | None = None

    def vector(self, n_dofs: int) -> Floats:
        """Return the pattern as an (n,) vector: a unit vector if it was given as a DOF.

        Raises SlipmodeError if the structure has no such DOF, or another number of them.
        """
        assert not isinstance(self.pattern, NodeDof)  # `Scene.located` has replaced nodes
        return _force_vector(f"forcing.{self.mode}", _by_dof(self.pattern), n_dofs)

    def rotating(self, n_dofs: int) -> Complexes:
        """Return the (n,) pattern f of Re(f exp(i (theta + phase))), with the quadrature.

        Raises SlipmodeError as `vector`.
        """
        if self.quadrature is None:
            return self.vector(n_dofs).astype(complex)
        later = _by_dof(self.quadrature)
        with naming(f"forcing.{self.mode}.quadrature"):
            return self.vector(n_dofs) - 1j * force_vector(later, n_dofs)


def _by_dof(pattern: int | tuple[float, ...]) -> Mapping[int, float] | tuple[float, ...]:
    return {pattern: 1.0} if isinstance(pattern, int) else pattern


@dataclass(frozen=True)
class Scene:
    """Hold a scene, checked as far as possible without its structure.

    Attributes
    ----------
    title, text, path, name : str, str, Path or None, str
        Title, TOML source, file, and name of the file without its ending.
    structure : Source or None
        Source of the matrices of a structure or of a sector; None with a saved model.
    friction : RigidFriction or None
        Law of rigid contacts.
    contacts : tuple of ContactGroup
        Groups of elastic contacts.
    preload : StaticForce or None
        Static force that presses contacts together, or opens them.
    mistuning : tuple of float
        Relative stiffness deviation of each blade [-]; empty if all blades are equal.
    saved_model : Model or None
        Saved model, instead of structure and contacts.
    limit_scale : Script or None
        Factor on friction limits and preloads over time [-]. None: constant.
    wear : float
        Share of the limits and preloads that is lost per dissipated energy [1/J].
    modes : Modes
        Numbers of the retained modes.
    forcing : mapping of str to Forcing
        Forces by mode, "A" or "B".
    initial : mapping of str to complex
        Amplitudes at t = 0 by mode [kg^1/2 m].
    aerodynamics : mapping of str to complex
        Aerodynamic influence coefficients by mode [rad^2/s^2], see `rom.reduce`.
    nonlinear_stiffness : mapping of str to float
        Coefficients by letters of modes, see `rom.with_nonlinear_stiffness`.
    run, model : Run, ModelOptions
        Duration and steps; options of the reduced model.
    contact, elastic : tuple of Window
        Windows of contact motion, and windows of motion of DOFs alone, in time order.
    output, log : Output, Log
        Recorded DOFs; recordings to write.
    units : Units
        Units of frequencies in the file, and of plots and tables. All frequencies of this object
        are in rad/s.
    """

    title: str
    structure: Source | None
    mistuning: tuple[float, ...]
    saved_model: Model | None
    friction: RigidFriction | None
    contacts: tuple[ContactGroup, ...]
    preload: StaticForce | None
    limit_scale: Script | None
    wear: float
    modes: Modes
    forcing: Mapping[str, Forcing]
    initial: Mapping[str, complex]
    aerodynamics: Mapping[str, complex]
    nonlinear_stiffness: Mapping[str, float]
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
    def disk(self) -> Source | None:
        """Structure if it is a bladed disk, whose modes are travelling waves; otherwise None."""
        return self.structure if self.structure and self.structure.sectors else None

    @property
    def windows(self) -> list[Window]:
        """All windows of fast motion, in time order."""
        return sorted((*self.contact, *self.elastic), key=lambda window: window.start)

    @property
    def tabulated(self) -> bool:
        """Whether the scene has a friction table over the amplitudes of one or two modes.

        Without a table it is integrated at full order, or many amplitudes share one tone.
        """
        return self.model.table != "none" and not self.mistuning and not self.modes.tones

    @property
    def switches(self) -> bool:
        """Whether a run uses full order where the transient error is too large."""
        possible = self.tabulated and self.model.formulation == "consistent" and self.disk is None
        fixed = self.limit_scale is None and not self.nonlinear_stiffness
        return possible and fixed and self.model.transients != "slow"

    @property
    def static_force(self) -> float | None:
        """Static force on one DOF [N] that alone presses the contacts together; otherwise None.

        Limits and preloads of the contacts scale with it.
        """
        force = self.preload.force if self.preload else None
        pressed = [np.any(getattr(group.law, "preload", 1.0)) for group in self.contacts]
        if not isinstance(force, Mapping) or len(force) > 1 or any(pressed):
            return None
        return float(next(iter(force.values())))

    def in_slow_time(self) -> Self:
        """Return the scene without intervals at full order.

        Returns
        -------
        Scene
            Scene with `model.transients = "slow"`.
        """
        return replace(self, model=replace(self.model, transients="slow"))

    def check_tuned(self) -> None:
        """Check that the scene has one or two modes, or waves, each with a force of its own.

        Raises
        ------
        SlipmodeError
            If the disk is mistuned, or several modes share a tone.
        """
        if self.modes.tones:
            raise SlipmodeError(
                "modes: this needs one mode on each tone; give one mode, or use slipmode plan "
                "(runner.plan_scene), run, curve, validate or fmu, rom.steady, or fmu.Component"
            )
        if self.mistuning:
            raise SlipmodeError(
                "mistuning: this needs a model of one or two waves, but a mistuned disk responds "
                "in all its modes; leave [mistuning] out, or use slipmode run, study, "
                "validate or plan (runner.plan_scene), or rom.MistunedDisk"
            )

    def check_tabulated(self) -> None:
        """Check that the scene has a friction table.

        Raises
        ------
        SlipmodeError
            If the scene is integrated at full order, or its disk is mistuned.
        """
        self.check_tuned()
        if not self.tabulated:
            raise SlipmodeError(
                'model.table = "none": must be "whole", because this needs a friction table'
            )

    def build(self) -> Structure:
        """Return the structure of the scene.

        Returns
        -------
        Structure
            Matrices and contact directions.

        Raises
        ------
        SlipmodeError
            If the scene has a saved model, or a disk of one sector.
        """
        if self.structure is None:
            raise SlipmodeError(
                "model.file: must be left out, because this needs a structure; give [structure] "
                "and its contacts instead"
            )
        if self.disk is not None:
            raise SlipmodeError(
                "structure.sectors: this needs a whole structure, but the scene has one sector; "
                "use slipmode diameters for its modes, or rom.CyclicStructure.annulus() for all "
                "sectors"
            )
        return self.structure.build()

    def located(self, labels: Labels | None) -> Self:
        """Return the scene with DOFs in place of nodes and directions.

        Parameters
        ----------
        labels : Labels or None
            Node and direction of each DOF.

        Returns
        -------
        Scene
            Scene whose forces and outputs are at DOFs.

        Raises
        ------
        SlipmodeError
            If the scene names a node and there are no labels, a node is not in them, or an output
            DOF occurs twice.
        """
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
            raise SlipmodeError(
                "output.nodes: DOFs must differ from each other and output.elastic"
            )
        return replace(self, forcing=forcing, output=Output(dofs))
