"""Stretches of a scene at full order, on the coordinates of the reduced model."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from slipmode.rom import Model, Reduced
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.full import Excitation, FullMotion, State, aeroelastic
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.structures import Projection
from slipmode.rom.laws.elements import Elements
from slipmode.rom.laws.states import stored_energy
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.motion import reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.validity import Finding
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.transients.demodulation import (
    amplitudes,
    carrier_signal,
    slow_parts,
    window_length,
)
from slipmode.runner.transients.motion import FastMotion


def excitation_of(modes: Sequence[str], patterns: np.ndarray, schedule: Schedule) -> Excitation:
    """Return the forces of some modes of a scene, with a segment for each step of a schedule.

    A complex pattern is two forces: Re(pattern exp(i theta)).
    """
    quantities = {"amplitude": "force", "frequency": "frequency", "phase": "phase"}
    rotates = bool(np.imag(patterns).any())
    every = [*modes, *modes] if rotates else modes
    scripted = {
        f"{name}{rate}": schedule.inputs([f"{quantity}{rate}_{m}" for m in every])
        for name, quantity in quantities.items()
        for rate in ("", "_rate")
    }
    patterns = np.vstack((patterns.real, patterns.imag)) if rotates else patterns.real
    if rotates:
        scripted["phase"][:, len(modes) :] += 0.5 * np.pi
    return Excitation(patterns=patterns, start=schedule.time(slice(schedule.steps)), **scripted)


def initial_state(plan: ModesPlan, excitation: Excitation) -> State:
    """Return the state of the structure at the start of a scene."""
    a, reduced = np.array(plan.excited.initial, dtype=complex), plan.excited.reduced
    shapes, tones = reduced.mode_shapes, list(reduced.tone_numbers) or slice(a.size)
    rate = 1j * excitation.frequency[0][tones] * a
    return State(0.0, displacement=shapes @ (2 * a.real), velocity=shapes @ (2 * rate.real))


def friction_loss(elements: Elements | None, motion: FullMotion) -> Floats:
    """Return the energy that friction has dissipated, without the energy in springs, (n,) [J].

    It is NaN where the energy in the springs of elastic contacts is unknown.
    """
    if elements is None:
        return motion.dissipated
    return motion.dissipated - stored_energy(
        elements, motion.contact_displacement, motion.contact_force
    )


@frozen
class SlowPart:
    """Slow quantities of a stretch at communication points."""

    # amplitude, rate, second: (points, modes): Amplitudes and their two derivatives
    amplitude: Complexes
    rate: Complexes
    second: Complexes
    # (points, 3): Input power, dissipated power [W], energy dissipated since the start of the
    # stretch [J]
    power: Floats


class FullOrder:
    """Full order of a scene, shared by all of its stretches.

    `integrator` has coordinates of the reduced model. `window` is the window of demodulation [s],
    `spacing` the spacing of its samples [s].
    """

    def __init__(self, plan: ModesPlan, reduced: Reduced) -> None:
        patterns = np.array(plan.excited.force_patterns)
        self._plan = plan
        small = Projection.of(plan.structure, reduced, list(patterns))
        shapes = small.to_coordinates @ reduced.mode_shapes
        self.projection = replace(small, structure=aeroelastic(small.structure, reduced, shapes))
        basis = self.projection.basis
        self.excitation = excitation_of(
            plan.excited.modes, patterns @ basis, plan.schedule.stretches()
        )
        modes = plan.excited.modes
        self.modes = len(modes)
        self.window = window_length(np.vstack(plan.schedule.frequencies(modes)))
        self.elements = reduced.contacts
        to_modes = self.projection.to_coordinates[: self.modes]
        modal = to_modes @ basis
        if reduced.contacts is None:  # without the part of the modes in the contact shapes
            shared = to_modes @ reduced.contact_shapes
            modal = modal - shared @ self.projection.structure.directions.T
        dofs = basis[list(plan.scene.output.elastic)]
        fastest = self.excitation.fastest(plan.scene.run.duration)
        self.spacing, step = 2 * np.pi / fastest / 24, plan.scene.run.step
        if step > self.spacing:  # samples then have the same places around all points
            self.spacing = step / round(step / self.spacing)
        self.integrator = Integrator(
            self.projection.structure,
            plan.excited.law,
            self.excitation,
            np.vstack((modal, patterns @ basis, dofs)),
            # errors stay far below the transient error of slow time that a stretch replaces
            steps_per_period=48,  # (tests/runner/transients/test_transient_errors.py)
        )

    @cached_property
    def jumps(self) -> Floats:
        """Times at which forces or frequencies, the first two `Loads`, jump [s]."""
        straight, excited = self._plan.schedule.stretches(), self._plan.excited
        found = np.zeros(straight.steps, dtype=bool)
        ends = excited.loads(straight.at_ends)
        for start, end in zip(excited.step_loads(straight)[:2], ends[:2], strict=True):
            size = np.maximum(np.abs(start).max(axis=0), np.abs(end).max(axis=0))
            jump = np.abs(start[1:] - end[:-1]) > 1e-9 * size  # less is rounding
            found[1:] |= np.any(jump, axis=1)
        return straight.time(slice(straight.steps))[found]

    def fast_motion(self, motion: FullMotion) -> FastMotion:
        """Return a motion as it is recorded."""
        return FastMotion(
            motion.time,
            motion.contact_displacement,
            motion.contact_velocity,
            motion.contact_force,
            motion.displacement[:, : self.modes],
            motion.displacement[:, 2 * self.modes :],
        )

    def first(self) -> State:
        """Return the state at the start of the scene."""
        return self.projection.state(initial_state(self._plan, self.excitation))

    def state_on(self, model: Model, trajectory: SlowTrajectory) -> State:
        """Return the state of slow time at the end of a trajectory of at least one period."""
        end, frequency = float(trajectory.time[-1]), trajectory.point_frequency[-1]
        fastest, slowest = 2 * np.pi / frequency.max(), 2 * np.pi / frequency.min()
        # the internal forces of elastic contacts come from motion over three slow periods
        spacing = fastest / 128
        samples = int(np.ceil(3.0 * slowest / spacing))
        past = end - spacing * np.arange(samples)[::-1]
        motion = reconstruct(model, trajectory, past[past >= trajectory.time[0]])
        one_sided = np.array([3.0, -16.0, 36.0, -48.0, 25.0]) / 12.0  # derivative of fourth order
        last = slice(1 - 2 * one_sided.size, None, 2)
        named = ("time", "displacement", "velocity", "force", "modal", "load")
        close = replace(motion, **{name: getattr(motion, name)[last] for name in named})
        x = close.elastic(model, range(model.reduced.n_dofs))
        velocity = one_sided @ x / (2 * spacing)
        state = self.projection.state(State(end, x[-1], velocity, motion.force[-1]))
        if model.reduced.contacts is None:
            return state
        _, memory = model.reduced.contacts.march(motion.displacement)
        return replace(state, contact_force=None, contact_memory=memory)


class Stretch:
    """From one communication point to another at full order."""

    def __init__(self, full: FullOrder, start: State) -> None:
        self.start, self.end = start.time, np.inf  # [s]; infinite until slow time goes on
        self.reached = start.time  # integrated up to here [s]
        self.last_fast = start.time  # when the estimated transient error was last too large [s]
        self.error = np.zeros(full.modes)  # the largest estimated error of slow time, relative
        self._full, self._modes, self._length = full, full.modes, full.window
        self._known, self._shown = [start], start  # states to continue from
        self._dissipated = 0.0  # so far, with the energy in springs
        self._time = np.empty(0)
        self._angle = np.empty((0, full.modes))
        self._signals = np.empty((0, full.modes + 2), dtype=complex)

    def advance(self, until: float) -> None:
        """Integrate at least to a time."""
        if until <= self.reached:
            return
        spacing = self._full.spacing
        count = int(np.ceil((until - self.reached) / spacing))
        times = np.asarray(self.reached + spacing * np.arange(1, count + 1), dtype=float)
        motion = self._full.integrator.run(times, self._known[-1])
        self._known.append(motion.end)
        self.reached = float(times[-1])
        self._time = np.append(self._time, times)
        self._angle = np.vstack((self._angle, self._full.excitation.at(times)[0]))
        self._signals = np.vstack((self._signals, self._slow_signals(motion)))

    def _slow_signals(self, motion: FullMotion) -> Complexes:
        """Return carrier signals, input power, and energy that friction dissipated."""
        modes = slice(0, self._modes)
        loaded = slice(self._modes, 2 * self._modes)
        angle, frequency, force = self._full.excitation.at(motion.time)
        moving = motion.displacement[:, modes], motion.velocity[:, modes]
        z = carrier_signal(*moving, angle, frequency)
        power = np.sum(force * motion.velocity[:, loaded], axis=1)
        loss = friction_loss(self._full.elements, motion)
        lost = self._dissipated + np.where(np.isfinite(loss), loss, motion.dissipated)
        self._dissipated += float(motion.dissipated[-1])
        return np.column_stack((z, power, lost))

    def slow(self, points: Floats) -> SlowPart:
        """Return slow quantities at communication points reached so far, later in each call."""
        values, rates, second = slow_parts(
            self._time, self._signals, self._angle, points, self._length
        )
        modes = slice(0, self._modes)
        _, frequency, _ = self._full.excitation.at(points)
        a, rate = amplitudes(values[:, modes], rates[:, modes], second[:, modes], frequency)
        power = np.column_stack((values[:, -2], rates[:, -1], values[:, -1])).real
        needed = np.searchsorted(self._time, points[-1] - self._length)
        self._time, self._angle = self._time[needed:], self._angle[needed:]
        self._signals = self._signals[needed:]
        return SlowPart(a, rate, second[:, modes], power)

    def motion(self, times: Floats) -> FastMotion:
        """Return the fast motion at increasing times inside the stretch."""
        before = [state for state in (*self._known, self._shown) if state.time <= times[0]]
        motion = self._full.integrator.run(times, max(before, key=lambda state: state.time))
        self._shown = motion.end
        return self._full.fast_motion(motion)


def integration_cost(plan: ModesPlan) -> list[Finding]:
    """Return the cost of full order, for the scene without a table and for stretches of it.

    It is extrapolated from four windows of demodulation, and eight points.
    """
    full = FullOrder(plan, plan.excited.reduced)
    stretch = Stretch(full, full.first())
    started = time.process_time()
    stretch.advance(4.0 * full.window)
    integrated = time.process_time()
    stretch.slow(np.linspace(0.0, stretch.reached, 8))
    demodulated = time.process_time()
    seconds = (integrated - started) * plan.scene.run.duration / stretch.reached
    seconds += (demodulated - integrated) * plan.schedule.steps / 8
    reason = 'a run with model.table = "none"; for many runs a friction table is faster'
    found = [Finding("full-order run", f"about {seconds:.2g} s of processor time", reason)]
    if plan.full_order:
        share = plan.full_order_share
        choice = f"about {share * seconds:.2g} s of processor time"
        reason = f"integrates {percentage(share)} of the scene; the rest is in slow time"
        found.append(Finding("full order in this run", choice, reason))
    return found
