"""Every key of a scene file: the only declaration of its kind, unit, default and meaning.

A table is a dataclass, a key one of its fields, and the docstring has the meanings (see
toml_table.py). The reader (scene.py), its refusals, `slipmode scenes --keys` and `--schema`, the
reference in the documentation and the keys of studies follow from `SceneFile`. The tables of the
structure and its contacts are in structure_keys.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal, get_args

from slipmode.rom.error_budget import SLOW_FLOW
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.frequencies import FrequencyUnit
from slipmode.rom.slow.units import LengthUnit, Units
from slipmode.rom.structure.labels import DIRECTIONS, Labels
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.structure_keys import (
    ContactsTable,
    FrictionTable,
    LimitsTable,
    MistuningTable,
    PreloadTable,
    StructureTable,
)
from slipmode.runner.scene.toml_table import Role, section_of
from slipmode.runner.scene.values import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    OneOrMore,
    between,
    choice,
    either,
    integer,
    numbers,
    rows,
    unit_choice,
)

_QUADRATURE = either(integer(), numbers(), "integer, or list of numbers")
_ZERO = Script.constant(0.0)
_AMPLITUDE = replace(NON_NEGATIVE, text=">= 0 (use phase to reverse the force)")
_RANGE = numbers(POSITIVE, of="one number per mode")


@dataclass(frozen=True)
class NodeDof:
    """A DOF by its node and direction, "x", "y", "z", "rx", "ry" or "rz"."""

    node: int
    direction: str

    def dof(self, key: str, labels: Labels | None, source: str) -> int:
        """Return the number of the DOF; a refusal names the key, and the source of the labels."""
        if labels is None:
            raise SlipmodeError(f"{key}: {source} no nodes; give numbers of DOFs")
        with naming(key):
            return labels.dof(self.node, self.direction)


@dataclass(frozen=True)
class ModesTable:
    """Retained modes with stuck contacts, counted from 0 by frequency. Not allowed with a saved
    model (`model.file`), which has its own modes.

    Attributes
    ----------
    A
        Number of the first mode, or of several modes within 15 % that `[forcing.A]` moves
        together: A, A2, A3, ... in recordings.
    B
        Number of the second mode, different from A, or of several modes that `[forcing.B]` moves
        together: B, B2, ... Default: a model with the modes A.
    ratio
        Frequency of mode B relative to mode A's frequency, for instance 3, if a harmonic of the
        contacts drives mode B (internal resonance). There is no `[forcing.B]` then. Default: mode
        B has a force and a frequency of its own.
    nodal_diameters
        Nodal diameter of each mode of a bladed disk, negative for a backward wave. Modes are
        counted from 0 for each. Default: the diameters that the engine orders excite.
    """

    A: OneOrMore
    B: OneOrMore | None = None
    ratio: Annotated[float | None, POSITIVE] = None
    nodal_diameters: Annotated[tuple[int, ...] | None, FINITE] = None


@dataclass(frozen=True, kw_only=True)
class ForcingTable:
    """Force on mode A, amplitude cos(theta + phase) with theta' = frequency. Give one of `dof`,
    `node` and `vector`. The table for mode B is `[forcing.B]`.

    Attributes
    ----------
    dof
        DOF on which the force acts.
    node
        Node on which the force acts, if the matrices have node numbers.
    direction
        Direction of the force at `node`.
    vector
        Force on every DOF per unit of `amplitude`.
    quadrature
        DOF, or force on every DOF per unit of `amplitude`, a quarter of a period later, so that
        the force rotates. With several modes on a tone.
    amplitude
        Force amplitude over time.
    frequency
        Forcing frequency over time, in the unit of `[units]`. Sweeps are continuous in phase. Give
        either `frequency` or `engine_order`.
    engine_order
        Forcing frequency as a multiple of `rotor_speed`. For a bladed disk it determines the
        excited nodal diameter, and `dof` is a DOF of every sector.
    rotor_speed
        Rotor speed over time in revolutions per minute, with `engine_order`.
    phase
        Phase of the force over time.
    """

    dof: int | None = None
    node: Annotated[int | None, FINITE] = None
    direction: Annotated[str | None, choice(*DIRECTIONS)] = None
    vector: tuple[float, ...] | None = None
    quadrature: Annotated[int | tuple[float, ...] | None, _QUADRATURE] = None
    amplitude: Annotated[Script, _AMPLITUDE, "N", Role.LOAD]
    frequency: Annotated[Script | None, POSITIVE, "rad/s", Role.LOAD] = None
    engine_order: Annotated[int | None, POSITIVE] = None
    rotor_speed: Annotated[Script | None, POSITIVE, "rpm", Role.LOAD] = None
    phase: Annotated[Script, "rad", Role.LOAD] = _ZERO


@dataclass(frozen=True)
class Forcings:
    """The forces by mode."""

    A: ForcingTable | None = None
    B: ForcingTable | None = None


@dataclass(frozen=True)
class Initial:
    """Modal amplitudes at the start.

    Attributes
    ----------
    A
        [re, im] of the amplitude a_A at t = 0. Default: 0.
    B
        [re, im] of the amplitude a_B at t = 0. Default: 0.
    """

    A: Annotated[complex | None, "kg^1/2 m"] = None
    B: Annotated[complex | None, "kg^1/2 m"] = None


@dataclass(frozen=True)
class Aerodynamics:
    """Aerodynamic influence coefficients, which may make a mode self-excited.

    Attributes
    ----------
    A
        [re, im] of the coefficient c_A; im < 0 supplies energy to the mode.
    B
        [re, im] of the coefficient c_B; im < 0 supplies energy to the mode.
    """

    A: Annotated[complex | None, "rad^2/s^2"] = None
    B: Annotated[complex | None, "rad^2/s^2"] = None


@dataclass(frozen=True)
class NonlinearStiffness:
    """Quadratic and cubic stiffness; a coefficient holds for each order of its letters.

    Attributes
    ----------
    AAA
        Quadratic coefficient alpha_AAA of mode A.
    AAB
        Quadratic coefficient alpha_AAB.
    ABB
        Quadratic coefficient alpha_ABB.
    BBB
        Quadratic coefficient alpha_BBB of mode B.
    AAAA
        Cubic coefficient gamma_AAAA of mode A; > 0 hardens.
    AAAB
        Cubic coefficient gamma_AAAB.
    AABB
        Cubic coefficient gamma_AABB: the stiffness of each mode with the square of the other.
    ABBB
        Cubic coefficient gamma_ABBB.
    BBBB
        Cubic coefficient gamma_BBBB of mode B; > 0 hardens.
    """

    AAA: Annotated[float | None, FINITE, "kg^-1/2 m^-1 s^-2"] = None
    AAB: Annotated[float | None, FINITE, "kg^-1/2 m^-1 s^-2"] = None
    ABB: Annotated[float | None, FINITE, "kg^-1/2 m^-1 s^-2"] = None
    BBB: Annotated[float | None, FINITE, "kg^-1/2 m^-1 s^-2"] = None
    AAAA: Annotated[float | None, FINITE, "kg^-1 m^-2 s^-2"] = None
    AAAB: Annotated[float | None, FINITE, "kg^-1 m^-2 s^-2"] = None
    AABB: Annotated[float | None, FINITE, "kg^-1 m^-2 s^-2"] = None
    ABBB: Annotated[float | None, FINITE, "kg^-1 m^-2 s^-2"] = None
    BBBB: Annotated[float | None, FINITE, "kg^-1 m^-2 s^-2"] = None


@dataclass(frozen=True)
class Run:
    """Duration and communication steps.

    Attributes
    ----------
    duration
        End of the scene; it starts at 0.
    step
        Communication step, the interval of recorded amplitudes, at least duration / 1e7. The
        solver chooses its internal steps.
    tolerance
        Relative tolerance of the solver of the slow flow.
    """

    duration: Annotated[float, POSITIVE, "s"]
    step: Annotated[float, POSITIVE, "s"]
    tolerance: Annotated[float, POSITIVE] = SLOW_FLOW


@dataclass(frozen=True)
class ModelOptions:
    """Options of the reduced model, or the file of a saved model.

    Attributes
    ----------
    file
        A model saved by `Model.save`, relative to the scene. It replaces `[structure]`,
        `[friction]`, `[[contacts]]`, `[modes]` and the other keys of this table.
    tolerance
        Relative tolerance of the friction table.
    formulation
        Formulation of the contact problem. "paper" is the formulation of the source paper;
        "consistent" adds the terms of first order that it neglects.
    amplitude
        Amplitude range of the friction table. Default: from a dry run.
    table
        "whole": with a friction table. "none": time integration at full order.
    transients
        Where to integrate at full order. "auto": where the estimated transient error exceeds the
        tolerance, at least 1 %. "slow": nowhere. "hybrid": where it exceeds 0.1 %.
    budget
        Largest computing time of the friction table. If it is too short, the message states what
        is possible in this time. Default: a limit of the work, some minutes.
    """

    file: str | None = None
    tolerance: Annotated[float, POSITIVE] = 1e-3
    formulation: Literal["consistent", "paper"] = "consistent"
    amplitude: Annotated[tuple[float, ...] | None, _RANGE, "kg^1/2 m"] = None
    table: Literal["whole", "none"] = "whole"
    transients: Literal["auto", "slow", "hybrid"] = "auto"
    budget: Annotated[float | None, POSITIVE, "s"] = None

    @property
    def transient_error(self) -> float:
        """Largest estimated transient error that slow time may have, relative to the range."""
        return 1e-3 if self.transients == "hybrid" else max(self.tolerance, 1e-2)


@dataclass(frozen=True)
class Window:
    """A time window with the fast motion of the contacts and of the DOFs in `[output]`. Windows
    must not overlap.

    Attributes
    ----------
    window
        [start, end], with start < end <= `run.duration`.
    samples_per_period
        Samples per period of the fastest carrier.
    """

    window: Annotated[tuple[float, float], NON_NEGATIVE, "s"]
    samples_per_period: Annotated[int, between(8, 4096)] = 64

    @property
    def start(self) -> float:
        """Start of the window [s]."""
        return self.window[0]

    @property
    def end(self) -> float:
        """End of the window [s]."""
        return self.window[1]


@dataclass(frozen=True)
class ElasticWindow(Window):
    """A time window with the fast motion of the DOFs in `[output]` alone."""


@dataclass(frozen=True)
class Output:
    """DOFs of the structure whose motion is recorded in the windows.

    Attributes
    ----------
    elastic
        DOFs, from 0.
    nodes
        DOFs by node, if the matrices have node numbers.
    """

    elastic: tuple[int, ...] = ()
    nodes: Annotated[tuple[NodeDof, ...], rows("[node, direction]", (int, str), of=NodeDof)] = ()


@dataclass(frozen=True)
class Log:
    """Recordings to write.

    Attributes
    ----------
    mcap
        Write an MCAP file.
    rerun
        Write an .rrd file with views for Rerun.
    """

    mcap: bool = True
    rerun: bool = True


@dataclass(frozen=True)
class UnitsTable(Units):
    """Units of forcing frequencies, and of curves and studies.

    Attributes
    ----------
    frequency
        Unit of forcing frequencies in this file, and of frequencies in curves and studies.
    displacement
        Unit of displacements of DOFs in curves and plots.
    """

    frequency: Annotated[FrequencyUnit, unit_choice(*get_args(FrequencyUnit))] = "rad/s"
    displacement: Annotated[LengthUnit, unit_choice(*get_args(LengthUnit))] = "m"


@dataclass(frozen=True, kw_only=True)
class SceneFile:
    """At the top of the file, before any table.

    Attributes
    ----------
    title
        Title of recordings and pictures.
    """

    title: str = ""
    structure: StructureTable
    mistuning: MistuningTable | None = None
    friction: FrictionTable | None = None
    contacts: tuple[ContactsTable, ...] = ()
    preload: PreloadTable | None = None
    limits: LimitsTable
    modes: ModesTable | None = None
    forcing: Forcings
    initial: Initial
    aerodynamics: Aerodynamics
    nonlinear_stiffness: NonlinearStiffness
    run: Run
    model: ModelOptions
    contact: tuple[Window, ...] = ()
    elastic: tuple[ElasticWindow, ...] = ()
    output: Output
    log: Log
    units: UnitsTable


SCENE = section_of(SceneFile)
