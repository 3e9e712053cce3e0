"""The modes of a scene that move, and the forces on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from slipmode.fmu import Component, StoppedError
from slipmode.rom import Friction, Model, Reduced
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.force_response import AppliedForces, phasor
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.cache import cached_model
from slipmode.rom.table.tabulation import extended_range
from slipmode.runner.plan.waves import Waves
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.schedule import Schedule


@frozen
class Path:
    """Amplitudes of a run after each internal step."""

    time: Floats  # (points,) [s], from 0
    amplitude: Complexes  # (points, modes) [kg^1/2 m]
    stop: StoppedError | None  # Why the run ended early


@frozen
class Excited:
    """The modes of a scene that move, and the forces on them."""

    modes: tuple[Mode, ...]  # Out of "A" and "B"
    reduced: Reduced
    law: Friction
    # Force on every DOF per unit of the scripted amplitude, for each tone; complex if it rotates
    force_patterns: tuple[Floats | Complexes, ...]
    initial: tuple[complex, ...]  # Motion of the modes at t = 0, as amplitudes [kg^1/2 m]
    # Amplitudes at t = 0: `initial` less the response of the modes to forces that act then
    amplitude: tuple[complex, ...]
    # Of a bladed disk; `reduced` and `law` then have no contacts
    waves: Waves | None = None

    @property
    def mode_names(self) -> Sequence[str]:
        """Names of the amplitudes: A and B, or A, A2, ..., B, B2, ... if modes share a tone."""
        return self.reduced.mode_names if self.reduced.shares_tone else self.modes

    @property
    def contacts(self) -> tuple[Reduced, Friction]:
        """Contacts and their law, which say where contacts slip: of waves those of a sector."""
        if self.waves is None:
            return self.reduced, self.law
        return self.waves.sector.problem.reduced, self.waves.law

    def model(
        self,
        amplitude: Sequence[float],
        tolerance: float,
        *,
        headroom: float = 1.0,
        **options: Any,
    ) -> tuple[Model, bool]:
        """Return the model up to amplitudes (modes,), and whether the cache had it.

        `options` are further keyword arguments of `cached_model`; waves need none of them.
        """
        if self.waves is not None:
            return self.waves.model(extended_range(amplitude, headroom), tolerance)
        return cached_model(
            self.reduced, self.law, amplitude, tolerance, headroom=headroom, **options
        )

    @cached_property
    def modal_force(self) -> Floats:
        """Modal force per unit of the scripted amplitude, (modes,) [kg^-1/2]."""
        patterns = enumerate(self.force_patterns)
        return np.array([self.reduced.modal_force(j, pattern) for j, pattern in patterns])

    def modal_forces(
        self, schedule: Schedule, steps: slice = slice(None)
    ) -> tuple[Complexes, Complexes]:
        """Return F_j exp(i phase_j) at the start and at the end of steps, (steps, modes)."""
        force, phase = ([f"{part}_{mode}" for mode in self.modes] for part in ("force", "phase"))
        start, end = (
            self.modal_force * phasor(values(force, steps), values(phase, steps))
            for values in (schedule.inputs, schedule.at_ends)
        )
        return start, end

    def started(self, schedule: Schedule) -> Self:
        """Return the same with the `amplitude` that follows from `initial` and the forces.

        In the paper's formulation it is `initial`.
        """
        if self.reduced.formulation == "paper":
            return self
        force, _ = self.modal_forces(schedule, slice(1))
        frequency = schedule.inputs([f"frequency_{mode}" for mode in self.modes], slice(1))
        forces = AppliedForces.of(self.reduced, self.force_patterns)
        at_rest = forces.free_vibration(force[0], frequency[0])
        return replace(self, amplitude=tuple((np.array(self.initial) + at_rest).tolist()))

    def component(self, model: Model, tolerance: float) -> Component:
        """Return a component at t = 0 of the scene; `tolerance` is of the slow flow."""
        component = Component(
            model, self.force_patterns, mode_names=self.modes, tolerance=tolerance, warned=False
        )
        component.reset(amplitude=self.amplitude)
        return component

    def follow(self, component: Component, durations: Floats, inputs: Floats) -> Path:
        """Return the path of a component from t = 0 through steps; see `Component.trace`."""
        width, stop = 1 + 2 * len(self.modes), None
        rows = [np.append(0.0, np.array(self.amplitude).view(float))[np.newaxis]]
        try:
            for outputs in component.trace(durations, inputs):
                rows.append(outputs[:, :width].copy())
        except StoppedError as error:
            stop = error
            rows.append(error.outputs[:, :width])
        traced = np.concatenate(rows)
        return Path(traced[:, 0], np.ascontiguousarray(traced[:, 1:]).view(complex), stop)

    def start(self) -> dict[str, float]:
        """Return the amplitudes at t = 0 by name of the component's outputs."""
        names = [f"{mode}_{part}" for mode in self.modes for part in ("re", "im")]
        return dict(zip(names, np.array(self.amplitude).view(float).tolist(), strict=True))
