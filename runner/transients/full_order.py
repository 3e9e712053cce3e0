"""A stretch of a scene at full order, on the coordinates of the reduced model."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, replace

import numpy as np

from slipmode.rom import Model, Reduced, kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.full import Excitation, FullMotion, State, aeroelastic
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.structures import Projection
from slipmode.rom.laws.states import stored_energy
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.motion import reconstruct
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.runner.plan.plan import Plan
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.transients.demodulation import (
    amplitudes,
    carrier_signal,
    slow_parts,
    window_length,
)

_STEPS_PER_PERIOD = 48
_SAMPLES_PER_PERIOD = 24  # of the fastest forcing, for demodulation
_ONE_SIDED = np.array([25.0, -48.0, 36.0, -16.0, 3.0]) / 12.0  # derivative at the last instant
_MEMORY_PERIODS = 3.0  # of the slowest carrier, that contacts are led through to remember
_MEMORY_SAMPLES = 128  # per period of the fastest


def excitation_of(plan: Plan, patterns: Floats, schedule: Schedule) -> Excitation:
    """The forces of a scene, a segment for each step of a schedule."""

    def scripted(quantity: str) -> Floats:
        return schedule.inputs([f"{quantity}_{mode}" for mode in plan.excited.modes])

    return Excitation(
        patterns=patterns,
        start=schedule.time(slice(schedule.steps)),
        amplitude=scripted("force"),
        amplitude_rate=scripted("force_rate"),
        frequency=scripted("frequency"),
        frequency_rate=scripted("frequency_rate"),
        phase=scripted("phase"),
        phase_rate=scripted("phase_rate"),
    )


def initial_state(plan: Plan, excitation: Excitation) -> State:
    """Where the structure of a scene starts."""
    a = np.array(plan.excited.initial, dtype=complex)
    shapes = plan.excited.reduced.mode_shapes
    return State(
        time=0.0,
        displacement=shapes @ (2 * a.real),
        velocity=shapes @ (2 * np.real(1j * excitation.frequency[0] * a)),
    )


def _sample_spacing(period: float, step: float) -> float:
    """Of samples for demodulation, which lie alike around all points that are steps apart."""
    spacing = period / _SAMPLES_PER_PERIOD
    return step / round(step / spacing) if step > spacing else spacing


@dataclass(frozen=True, eq=False)
class FastMotion:
    """Motion at given times, in slow time or at full order.

    Attributes
    ----------
    time : (n,) ndarray
        [s]
    displacement, velocity, force : (n, N_c) ndarray
        Of the contacts [m], [m/s], [N].
    modal : (n, modes) ndarray
        Displacements of the retained modes [kg^1/2 m].
    elastic : (n, dofs) ndarray
        Of the scene's output.elastic [m].
    """

    time: Floats
    displacement: Floats
    velocity: Floats
    force: Floats
    modal: Floats
    elastic: Floats

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class SlowPart:
    """What a recording has of a stretch at communication points.

    Attributes
    ----------
    amplitude, rate : (points, modes) complex ndarray
    power : (points, 3) ndarray
        Input power, dissipated power [W], energy dissipated since the start of the stretch [J].
    """

    amplitude: Complexes
    rate: Complexes
    power: Floats

    __repr__ = short_repr


class FullOrder:
    """Full order of a scene: what all of its stretches share.

    Attributes
    ----------
    modes : int
    window : float
        Of demodulation [s].
    """

    def __init__(self, plan: Plan, reduced: Reduced) -> None:
        patterns = np.array(plan.excited.force_patterns)
        self._plan = plan
        small = Projection.of(plan.structure, reduced, list(patterns))
        shapes = small.to_coordinates @ reduced.mode_shapes
        self.projection = replace(small, structure=aeroelastic(small.structure, reduced, shapes))
        basis = self.projection.basis
        straight, modes = plan.schedule.stretches(), plan.excited.modes
        self.excitation = excitation_of(plan, patterns @ basis, straight)
        frequencies = [f"frequency_{mode}" for mode in modes]
        ends = straight.inputs(frequencies), straight.at_ends(frequencies)
        self.modes, self.window = len(modes), window_length(np.vstack(ends))
        self.elements = reduced.contacts
        modal = self.projection.to_coordinates[: len(reduced.modes)] @ basis
        if reduced.contacts is None:  # less what the contact shapes have of the modes
            shared = self.projection.to_coordinates[: len(reduced.modes)] @ reduced.contact_shapes
            modal = modal - shared @ self.projection.structure.directions.T
        dofs = basis[list(plan.scene.output.elastic)]
        fastest = self.excitation.fastest(plan.scene.run.duration)
        self.spacing = _sample_spacing(2 * np.pi / fastest, plan.scene.run.step)
        self._integrator = Integrator(
            self.projection.structure,
            plan.excited.law,
            self.excitation,
            np.vstack((modal, patterns @ basis, dofs)),
            _STEPS_PER_PERIOD,
        )

    def run(self, times: Floats, start: State) -> FullMotion:
        """Motion at times from a state of the coordinates."""
        return self._integrator.run(times, start)

    def lost(self, motion: FullMotion) -> Floats:
        """Energy that friction took, without what springs of contacts hold where that is known."""
        if self.elements is None:
            return motion.dissipated
        held = stored_energy(self.elements, motion.contact_displacement, motion.contact_force)
        return motion.dissipated - np.where(np.isfinite(held), held, 0.0)

    def first(self) -> State:
        """The start of the scene."""
        return self._on_coordinates(initial_state(self._plan, self.excitation))

    def state_on(self, model: Model, trajectory: SlowTrajectory) -> State:
        """Where the motion of slow time is at the end of a trajectory, a period long at least."""
        end, frequency = float(trajectory.time[-1]), trajectory.point_frequency[-1]
        fastest, slowest = 2 * np.pi / frequency.max(), 2 * np.pi / frequency.min()
        samples = int(np.ceil(_MEMORY_PERIODS * slowest * _MEMORY_SAMPLES / fastest))
        spacing = fastest / _MEMORY_SAMPLES
        past = end - spacing * np.arange(samples)[::-1]
        motion = reconstruct(model, trajectory, past[past >= trajectory.time[0]])
        last = slice(1 - 2 * _ONE_SIDED.size, None, 2)
        named = ("time", "displacement", "velocity", "force", "modal", "load")
        close = replace(motion, **{name: getattr(motion, name)[last] for name in named})
        x = close.elastic(model, range(model.reduced.n_dofs))
        state = State(
            time=end,
            displacement=x[-1],
            velocity=_ONE_SIDED[::-1] @ x / (2 * spacing),
            contact_force=motion.force[-1],
        )
        state = self._on_coordinates(state)
        if model.reduced.contacts is None:
            return state
        memory = _memory(model.reduced.contacts.kernel(), motion.displacement)
        return replace(state, contact_force=None, contact_memory=memory)

    def _on_coordinates(self, state: State) -> State:
        to = self.projection.to_coordinates
        return replace(state, displacement=to @ state.displacement, velocity=to @ state.velocity)


def _memory(elastic: kernel.Elastic, x_c: Floats) -> Floats:
    """What elastic contacts remember that moved through displacements (n, N_c)."""
    contacts = x_c.shape[1]
    memory = np.zeros(int(kernel.lib.sm_elastic_memory(ctypes.byref(elastic))))
    force = np.empty(contacts)
    for row in kernel.contiguous(x_c):
        status = kernel.lib.sm_elastic_force(
            *(ctypes.byref(elastic), contacts, row.ctypes.data),
            *(memory.ctypes.data, force.ctypes.data),
        )
        kernel.check(status, "forces on the contacts")
    return memory


class Stretch:
    """From one communication point to another at full order.

    Attributes
    ----------
    start, end : float
        [s]; the end is infinite until it is handed back.
    reached : float
        Up to where it is integrated [s].
    last_fast : float
        When the estimated transient error was too large last [s].
    error : (modes,) ndarray
        The largest estimated transient error that slow time would have, relative.
    """

    def __init__(self, full: FullOrder, start: State) -> None:
        self.start, self.end = start.time, np.inf
        self.reached = self.last_fast = start.time
        self.error = np.zeros(full.modes)
        self._full, self._modes, self._length = full, full.modes, full.window
        self._known, self._shown = [start], start  # states to go on from
        self._spacing = full.spacing
        self._lost = 0.0  # in all motion so far, springs not looked at
        self._time = np.empty(0)
        self._angle = np.empty((0, full.modes))
        self._signals = np.empty((0, full.modes + 2), dtype=complex)

    def advance(self, until: float) -> None:
        """Integrate to a time at least."""
        if until <= self.reached:
            return
        count = int(np.ceil((until - self.reached) / self._spacing))
        times = np.asarray(self.reached + self._spacing * np.arange(1, count + 1), dtype=float)
        motion = self._full.run(times, self._known[-1])
        self._known.append(motion.end)
        self.reached = float(times[-1])
        self._time = np.append(self._time, times)
        self._angle = np.vstack((self._angle, self._full.excitation.at(times)[0]))
        self._signals = np.vstack((self._signals, self._slow_signals(motion)))

    def _slow_signals(self, motion: FullMotion) -> Complexes:
        """What turns with the carriers, input power, and energy that friction took."""
        modes = slice(0, self._modes)
        loaded = slice(self._modes, 2 * self._modes)
        angle, frequency, force = self._full.excitation.at(motion.time)
        moving = motion.displacement[:, modes], motion.velocity[:, modes]
        z = carrier_signal(*moving, angle, frequency)
        power = np.sum(force * motion.velocity[:, loaded], axis=1)
        lost = self._lost + self._full.lost(motion)
        self._lost += float(motion.dissipated[-1])
        return np.column_stack((z, power, lost))

    def slow(self, points: Floats) -> SlowPart:
        """At communication points that have been reached; later calls have later ones."""
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
        return SlowPart(a, rate, power)

    def motion(self, times: Floats) -> FastMotion:
        """Fast motion at increasing times inside."""
        before = [state for state in (*self._known, self._shown) if state.time <= times[0]]
        motion = self._full.run(times, max(before, key=lambda state: state.time))
        self._shown = motion.end
        own = slice(0, self._modes)
        return FastMotion(
            times,
            motion.contact_displacement,
            motion.contact_velocity,
            motion.contact_force,
            motion.displacement[:, own],
            motion.displacement[:, 2 * self._modes :],
        )
