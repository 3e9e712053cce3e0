"""The modes of a scene that move, and the forces on them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from slipmode.fmu import Component, StoppedError
from slipmode.rom import Friction, Model, Reduced, Structure
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.laws.elements import SLIDERS
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.force_response import AppliedForces, phasor
from slipmode.rom.reduction.tones import combinations_along
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.cache import cached_model
from slipmode.rom.validity import Finding
from slipmode.runner.recording import channels
from slipmode.runner.recording.channels import Channel, Mode, Moved
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene


class Moving(Protocol):
    """What a scene moves, for plans and recordings."""

    kind: ClassVar[str]  # Which pass goes through the scene: a key of `runner.run.PASSES`

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Modes, or tones, that have a force: "A" and "B"."""

    @property
    def natural(self) -> Mapping[str, float]:
        """Frequency of each of them without a force [rad/s]; 0 if it always has one."""

    @property
    def n_dofs(self) -> int:
        """Number of DOFs that can be recorded."""

    def summary(self, scene: Scene) -> str:
        """Return what moves, and how it is computed, for the first event of a recording."""

    def channels(self, scene: Scene) -> list[Channel]:
        """Return the channels that a run records."""

    def moved(self, amplitude: Sequence[float]) -> dict[str, Moved]:
        """Return what each mode moves, whose amplitudes are expected to reach some values."""


class Path(NamedTuple):
    """Amplitudes of a run after each internal step."""

    time: Floats  # (points,) [s], from 0
    amplitude: Complexes  # (points, modes) [kg^1/2 m]
    energy: Floats  # (points,) dissipated at the contacts [J]
    stop: StoppedError | None  # Why the run ended early


class Loads(NamedTuple):
    """Forces on modes, and the scale of friction limits, at points."""

    force: Complexes  # (points, modes): F_j exp(i phase_j), modal [N kg^-1/2]
    frequency: Floats  # (points, modes) [rad/s]
    scale: Floats  # (points, 1): Scale of limits and preloads [-]


@frozen
class Excited:
    """The modes of a scene that move, and the forces on them."""

    kind: ClassVar[str] = "modes"

    modes: tuple[Mode, ...]  # Out of "A" and "B"
    reduced: Reduced
    law: Friction
    # Force on every DOF per unit of the scripted amplitude, for each tone; complex if it rotates
    force_patterns: tuple[Floats | Complexes, ...]
    initial: tuple[complex, ...]  # Motion of the modes at t = 0, as amplitudes [kg^1/2 m]
    # Amplitudes at t = 0: `initial` less the response of the modes to forces that act then
    amplitude: tuple[complex, ...]

    @property
    def natural(self) -> dict[str, float]:
        """See `Moving`."""
        return dict(zip(self.modes, self.reduced.frequency.tolist(), strict=True))

    @property
    def n_dofs(self) -> int:
        """See `Moving`."""
        return self.reduced.n_dofs

    @property
    def mode_names(self) -> Sequence[str]:
        """Names of the amplitudes: A and B, or A, A2, ..., B, B2, ... if modes share a tone."""
        return self.modes

    @property
    def structure(self) -> Structure | None:
        """Structure of the modes; None with a saved model, or for waves of a disk."""
        return self.reduced.structure

    @property
    def contacts(self) -> tuple[Reduced, Friction]:
        """Contacts and their law, which say where contacts slip: of waves those of a sector."""
        return self.reduced, self.law

    def summary(self, scene: Scene) -> str:
        """See `Moving`."""
        if not scene.tabulated:
            return "integrated without a friction table"
        contacts, _ = self.contacts
        return (
            f"mode {' and '.join(self.modes)}, {contacts.n_contacts} contacts, "
            f"{contacts.formulation} formulation, table tolerance {scene.model.tolerance:g}"
        )

    def channels(self, scene: Scene) -> list[Channel]:
        """See `Moving`."""
        reduced, _ = self.contacts
        saved = scene.saved_model
        listed = [
            channels.modes(self.mode_names, saved is not None and saved.samples is not None),
            channels.forcing(self.modes),
            channels.energy(),
        ]
        if scene.wear:
            listed.append(channels.control())
        if scene.contact:
            listed += contact_channels(reduced)
            if reduced.contacts is not None:
                listed.append(channels.contact_share(len(reduced.contacts.element)))
            if len(self.modes) == 2:
                listed.append(channels.phases())
                listed += [channels.torus()] if scene.tabulated and scene.disk is None else []
        if scene.output.elastic:
            listed.append(channels.elastic(scene.output.elastic))
        return listed

    def moved(self, amplitude: Sequence[float] = ()) -> dict[str, Moved]:
        """See `Moving`: the DOF that each mode moves most; views show its displacement."""
        shapes, structure = displacement_shapes(self.reduced), self.structure
        contacts = np.zeros((1, shapes.shape[1]))
        if structure is not None:
            contacts = np.abs(np.asarray(structure.directions.T @ self.reduced.mode_shapes))
        largest = amplitude or np.zeros(shapes.shape[1])
        columns = zip(self.mode_names, shapes.T, contacts.T, largest, strict=True)
        return {name: Moved(x.max(), int(x.argmax()), c.max(), a) for name, x, c, a in columns}

    def at_carriers(self, frequency: Sequence[float]) -> Self:
        """Return the same modes with carriers of these frequencies [rad/s]."""
        reduced = self.reduced.at_carrier(frequency)
        return replace(
            self, reduced=replace(reduced, force_patterns=np.array(self.force_patterns))
        )

    def combinations(self, schedule: Schedule) -> tuple[CombinationResonance, ...]:
        """Return the harmonics that come near a carrier in a schedule."""
        return combinations_along(self.reduced, *schedule.frequencies(self.modes), transient=True)

    def other_modes(self) -> Finding:
        """Return how the modes that are not retained are modelled."""
        reduced, choice = self.reduced, "quasi-static response"
        responding = reduced.nonresonant_frequency
        if reduced.formulation == "paper":
            return Finding("other modes", choice, 'model.formulation is "paper"')
        if not responding.size:
            reason = "no harmonic of the contacts excites another mode dynamically"
            return Finding("other modes", choice, reason)
        reason = (
            f"the modes at {listed(responding)} rad/s respond dynamically to harmonics of the "
            "contacts"
        )
        return Finding("other modes", f"{responding.size} in the friction table", reason)

    def model(
        self, amplitude: Sequence[float], tolerance: float, **options: Any
    ) -> tuple[Model, bool]:
        """Return the model up to amplitudes (modes,), and whether the cache had it.

        `options` are further keyword arguments of `cached_model`.
        """
        return cached_model(self.reduced, self.law, amplitude, tolerance, **options)

    @cached_property
    def modal_force(self) -> Floats:
        """Modal force per unit of the scripted amplitude, (modes,) [kg^-1/2]."""
        patterns = enumerate(self.force_patterns)
        return np.array([self.reduced.modal_force(j, pattern) for j, pattern in patterns])

    def loads(self, values: Callable[[Sequence[str]], Floats]) -> Loads:
        """Return the loads at points; `values` returns inputs by name, (points, names)."""
        parts = ("force", "phase", "frequency")
        given = values(
            [*(f"{part}_{mode}" for part in parts for mode in self.modes), "limit_scale"]
        )
        force, phase, frequency = np.split(given[:, :-1], len(parts), axis=1)
        return Loads(force * phasor(self.modal_force, phase), frequency, given[:, -1:])

    def step_loads(self, schedule: Schedule, steps: slice = slice(None)) -> Loads:
        """Return the loads at the starts of steps."""
        return self.loads(partial(schedule.inputs, steps=steps))

    def load_rates(self, schedule: Schedule, steps: slice = slice(None)) -> Loads:
        """Return the rates of the loads at the starts of steps [1/s]."""
        parts = ("force", "force_rate", "phase", "phase_rate", "frequency_rate")
        names = [f"{part}_{mode}" for part in parts for mode in self.modes]
        given = schedule.inputs([*names, "limit_scale_rate"], steps)
        size, rate, phase, turning, of_frequency = np.split(given[:, :-1], len(parts), axis=1)
        per_unit = phasor(self.modal_force, phase)
        force_rate = rate * per_unit + 1j * turning * (size * per_unit)
        return Loads(force_rate, of_frequency, given[:, -1:])

    def started(self, schedule: Schedule) -> Self:
        """Return the same with the `amplitude` that follows from `initial` and the forces.

        In the paper's formulation it is `initial`.
        """
        if self.reduced.formulation == "paper":
            return self
        start = self.step_loads(schedule, slice(1))
        forces = AppliedForces.of(self.reduced, self.force_patterns)
        at_rest = forces.free_vibration(start.force[0], start.frequency[0])
        return replace(self, amplitude=tuple((np.array(self.initial) + at_rest).tolist()))

    def component(self, model: Model, tolerance: float, sample: int = 0) -> Component:
        """Return a component at t = 0 of the scene; `tolerance` is of the slow flow."""
        options: dict[str, Any] = {"tolerance": tolerance, "sample": sample, "warned": False}
        component = Component(model, self.force_patterns, mode_names=self.modes, **options)
        component.reset(amplitude=self.amplitude)
        return component

    def follow(self, model: Model, schedule: Schedule, tolerance: float) -> Path:
        """Return the path of a component from t = 0 through the steps of a schedule."""
        component = self.component(model, tolerance)
        parts = [f"{mode}_{part}" for mode in self.modes for part in ("re", "im")]
        columns = [component.output_names.index(n) for n in ("time", *parts, "dissipated_energy")]
        start, stop = np.array(self.amplitude).view(float), None
        rows = [np.concatenate(([0.0], start, [0.0]))[np.newaxis]]
        inputs = schedule.inputs(component.input_names)
        try:
            for outputs in component.trace(schedule.durations(), inputs):
                rows.append(outputs[:, columns])
        except StoppedError as error:
            stop = error
            rows.append(error.outputs[:, columns])
        traced = np.concatenate(rows)
        amplitude = np.ascontiguousarray(traced[:, 1:-1]).view(complex)
        return Path(traced[:, 0], amplitude, traced[:, -1], stop)

    def start(self) -> dict[str, float]:
        """Return the amplitudes at t = 0 by name of the component's outputs."""
        names = [f"{mode}_{part}" for mode in self.modes for part in ("re", "im")]
        return dict(zip(names, np.array(self.amplitude).view(float).tolist(), strict=True))


def initial_amplitudes(scene: Scene, modes: Sequence[Mode]) -> tuple[complex, ...]:
    """Return the given motion of modes at t = 0, as amplitudes [kg^1/2 m]."""
    return tuple(complex(scene.initial.get(mode, 0.0)) for mode in modes)


def listed(frequency: Floats) -> str:
    """Return frequencies in words."""
    return ", ".join(f"{omega:.3g}" for omega in frequency)


def displacement_shapes(reduced: Reduced) -> Floats:
    """Return |mode_shapes| (n_dofs, modes) [kg^-1/2], 0 for rotations."""
    shapes, structure = np.abs(reduced.mode_shapes), reduced.structure
    if structure is not None and structure.labels is not None:
        shapes[structure.labels.direction > 3] = 0.0
    return shapes


def contact_channels(reduced: Reduced, prefix: str = "") -> list[Channel]:
    """Return the channels of the contacts: contact DOFs if rigid, elements of an elastic law."""
    if reduced.contacts is None:
        return [channels.contact(i, prefix) for i in range(reduced.n_contacts)]
    return [
        channels.elastic_contact(i, tangents(element), prefix)
        for i, element in enumerate(reduced.contacts.element)
    ]


def tangents(element: np.void) -> int:
    """Return the number of tangential directions; 0 for a law without a normal."""
    return 0 if element["law"] == SLIDERS else int(element["tangents"])
