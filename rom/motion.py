"""Contact and elastic motion from the slow amplitudes.

The contact problem (12) is marched along the slow trajectory, pulled also by the modes' answer to
its harmonics. Friction forgets within a few periods, so any window can be had without marching
from t = 0.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rom import _kernel
from rom.amplitude import Complexes, amplitude_rate
from rom.answer import ModalAnswer, modal_answer
from rom.errors import SlipmodeError
from rom.matrices import Floats
from rom.model import Model
from rom.torus import contact_problem

SPIN_UP_PERIODS = 10.0


@dataclass(frozen=True, eq=False)
class SlowTrajectory:
    """Amplitudes, carriers and forcing at successive times; straight-line inputs in between.

    Attributes
    ----------
    time : (steps + 1,) ndarray
        [s]
    amplitude : (steps + 1, modes) complex ndarray
    angle : (steps + 1, modes) ndarray
        Carrier angles theta_j [rad]; whole turns do not matter.
    frequency, frequency_rate : (steps, modes) ndarray
        At the start of each step [rad/s], [rad/s^2].
    force, force_rate : (steps, modes) complex ndarray
        Modal F_j exp(i phase_j) at the start of each step [N kg^-1/2], and its rate.
    shift : (modes,) complex ndarray or float
        What the contacts feel on top of a_j, per unit of force: rom.amplitude.felt_shift.
    """

    time: Floats
    amplitude: Complexes
    angle: Floats
    frequency: Floats
    frequency_rate: Floats
    force: Complexes
    force_rate: Complexes
    shift: Complexes | float = 0.0

    @property
    def point_frequency(self) -> Floats:
        """Forcing frequencies at every time, (steps + 1, modes)."""
        last = self.frequency[-1] + self.frequency_rate[-1] * (self.time[-1] - self.time[-2])
        return np.vstack((self.frequency, last))

    def between(self, start: float, end: float) -> SlowTrajectory:
        """The steps that overlap [start, end]."""
        steps = self.time.size - 1
        first = min(max(int(np.searchsorted(self.time, start, side="right")) - 1, 0), steps - 1)
        last = min(max(int(np.searchsorted(self.time, end, side="left")), first + 1), steps)
        points, within = slice(first, last + 1), slice(first, last)
        return SlowTrajectory(
            self.time[points],
            self.amplitude[points],
            self.angle[points],
            self.frequency[within],
            self.frequency_rate[within],
            self.force[within],
            self.force_rate[within],
            self.shift,
        )

    def amplitude_rates(self, model: Model) -> tuple[Complexes, Complexes]:
        """da/dt at the start and at the end of each step, (steps, modes)."""
        later = np.diff(self.time)[:, np.newaxis]
        rates = self.frequency_rate
        start = amplitude_rate(
            model,
            self.amplitude[:-1],
            self.frequency,
            self.force,
            rates,
            self.shift,
            self.force_rate,
        )
        end = amplitude_rate(
            model,
            self.amplitude[1:],
            self.frequency + rates * later,
            self.force + self.force_rate * later,
            rates,
            self.shift,
            self.force_rate,
        )
        return start, end

    def segments(self, model: Model, pull: Complexes) -> np.ndarray:
        """The steps as the core reads them; `pull` (steps + 1, orders, N_c) must outlive them."""
        duration = np.diff(self.time)
        later = duration[:, np.newaxis]
        segments = np.zeros(duration.size, dtype=_kernel.SEGMENT)
        segments["start"], segments["duration"] = self.time[:-1], duration
        modes = slice(0, model.modes)
        rates = self.frequency_rate
        force_end = self.force + self.force_rate * later
        moving = self.shift * self.force_rate
        segments["amplitude_start"][:, modes] = self.amplitude[:-1] + self.shift * self.force
        segments["amplitude_end"][:, modes] = self.amplitude[1:] + self.shift * force_end
        start, end = self.amplitude_rates(model)
        segments["rate_start"][:, modes] = start + moving
        segments["rate_end"][:, modes] = end + moving
        segments["angle"][:, modes] = self.angle[:-1]
        segments["frequency"][:, modes] = self.frequency
        segments["frequency_rate"][:, modes] = rates
        segments["pull_start"] = pull.ctypes.data + pull.strides[0] * np.arange(duration.size)
        segments["pull_end"] = segments["pull_start"] + pull.strides[0]
        return segments


@dataclass(frozen=True, eq=False)
class Motion:
    """Fast motion at given times.

    Attributes
    ----------
    time : (n,) ndarray
        [s]
    displacement, velocity, force : (n, N_c) ndarray
        Of the contacts: x_c [m], x_c' [m/s], friction force [N].
    modal : (n, modes + passive) ndarray
        Modal displacements q_j [kg^1/2 m], those of passive modes last.
    """

    time: Floats
    displacement: Floats
    velocity: Floats
    force: Floats
    modal: Floats

    def elastic(self, model: Model, dofs: Sequence[int]) -> Floats:
        """Displacement of DOFs of the structure, (n, dofs) [m]."""
        rows = list(dofs)
        shapes = model.reduced.all_shapes[rows], model.reduced.contact_shapes[rows]
        return np.asarray(self.modal @ shapes[0].T + self.displacement @ shapes[1].T)


def reconstruct(
    model: Model,
    trajectory: SlowTrajectory,
    times: ArrayLike,
    *,
    steps_per_period: int = 128,
    spin_up: float = SPIN_UP_PERIODS,
) -> Motion:
    """Contact and modal motion at increasing times inside a slow trajectory.

    Parameters
    ----------
    times : (n,) array_like
        [s]
    steps_per_period : int
        Least number of time steps per period of the faster carrier.
    spin_up : float
        Periods of the slower carrier marched before the first time, at most from the
        trajectory's start, where the contacts rest.

    Raises
    ------
    SlipmodeError
        If the times are not increasing or lie outside the trajectory.
    """
    sample = _kernel.contiguous(times)
    first, last = trajectory.time[[0, -1]]
    if sample.size == 0 or not np.all(np.isfinite(sample)) or np.any(np.diff(sample) <= 0):
        raise SlipmodeError("times: must be finite and increasing, at least one")
    if sample[0] < first or sample[-1] > last + 1e-9 * (last - first):
        raise SlipmodeError(f"times: must lie within the run, {first:g} to {last:g} s")
    slowest = trajectory.frequency.min()
    part = trajectory.between(sample[0] - spin_up * 2 * np.pi / slowest, sample[-1])
    answer = modal_answer(model, part.amplitude, part.point_frequency)
    pull = np.ascontiguousarray(answer.pull)
    segments = part.segments(model, pull)
    shape = (sample.size, model.reduced.n_contacts)
    x, v, f = np.empty(shape), np.empty(shape), np.empty(shape)
    problem = contact_problem(model.reduced, model.law, model.near, answer.orders)
    status = _kernel.lib.sm_contact_motion(
        *(ctypes.byref(problem), len(segments), segments.ctypes.data, None, steps_per_period),
        *(sample.size, sample.ctypes.data, x.ctypes.data, v.ctypes.data, f.ctypes.data),
    )
    _kernel.check(status, "contact motion")
    return Motion(sample, x, v, f, _modal_motion(model, part, answer, sample))


def _modal_motion(
    model: Model, part: SlowTrajectory, answer: ModalAnswer, times: Floats
) -> Floats:
    """q_j: the carrier, a_j by cubic Hermite interpolation, and the answer to the harmonics."""
    step = np.clip(np.searchsorted(part.time, times, side="right") - 1, 0, part.time.size - 2)
    elapsed = (times - part.time[step])[:, np.newaxis]
    duration = np.diff(part.time)[step, np.newaxis]
    r = elapsed / duration
    end = r * r * (3 - 2 * r)
    rate_start, rate_end = part.amplitude_rates(model)
    a = (
        (1 - end) * part.amplitude[step]
        + end * part.amplitude[step + 1]
        + duration * r * (1 - r) ** 2 * rate_start[step]
        - duration * r * r * (1 - r) * rate_end[step]
    )
    turned = part.frequency[step] + 0.5 * part.frequency_rate[step] * elapsed
    angle = part.angle[step] + elapsed * turned
    modal = np.zeros((times.size, model.reduced.all_shapes.shape[1]))
    modal[:, : model.modes] = 2 * np.real(a * np.exp(1j * angle))
    for q, order in enumerate(answer.orders):
        start, finish = answer.modal[step, q], answer.modal[step + 1, q]
        turn = np.exp(1j * (angle @ np.array(order[: model.modes])))[:, np.newaxis]
        modal += 2 * np.real((start + r * (finish - start)) * turn)
    return modal
