"""The slow trajectory: what amplitudes and carriers did, for the reconstruction of motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import ForceResponse
from slipmode.rom.reduction.reduced import coupling_factor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.slow_flow import inputs_of, rates, shifted_flow
from slipmode.rom.table.model import Model

# Of a cubic from point to point, of the largest amplitude: by how much it may leave the slow flow.
_BENT = 3e-4
_MOST_PARTS, _ORDER = 256, 3  # of a step; by which a part of it bends less, at least


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
    force_response : ForceResponse, optional
        What the forces do past their own mode. Default: nothing.
    discontinuity : (steps, modes) complex ndarray, optional
        What discontinuities of the forces add to the amplitudes at the start of each step.
        Default: nothing.
    scale, scale_rate : (steps,) ndarray, optional
        Limits and preloads relative to the model's at the start of each step, and their rate
        [1/s]. Default: those of the model.
    """

    time: Floats
    amplitude: Complexes
    angle: Floats
    frequency: Floats
    frequency_rate: Floats
    force: Complexes
    force_rate: Complexes
    force_response: ForceResponse | None = None
    discontinuity: Complexes | None = None
    scale: Floats | None = None
    scale_rate: Floats | None = None

    __repr__ = short_repr

    @property
    def amplitude_start(self) -> Complexes:
        """Amplitudes at the start of each step, past its discontinuity, (steps, modes)."""
        before = self.amplitude[:-1]
        return before if self.discontinuity is None else before + self.discontinuity

    @property
    def shift(self) -> Complexes | float:
        """What the effective amplitudes at the contacts have besides a_j, per unit of force."""
        return self.force_response.shift if self.force_response else 0.0

    @property
    def point_force(self) -> Complexes:
        """Modal forces at every time, (steps + 1, modes)."""
        last = self.force[-1] + self.force_rate[-1] * (self.time[-1] - self.time[-2])
        return np.vstack((self.force, last))

    @property
    def point_frequency(self) -> Floats:
        """Forcing frequencies at every time, (steps + 1, modes)."""
        last = self.frequency[-1] + self.frequency_rate[-1] * (self.time[-1] - self.time[-2])
        return np.vstack((self.frequency, last))

    def scale_at(self, times: Floats) -> Floats:
        """Limits and preloads relative to the model's at times inside, right of jumps (n,)."""
        if self.scale is None or self.scale_rate is None:
            return np.ones(times.size)
        last = self.scale.size - 1
        k = np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, last)
        return np.asarray(self.scale[k] + self.scale_rate[k] * (times - self.time[k]))

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
            self.force_response,
            None if self.discontinuity is None else self.discontinuity[within],
            None if self.scale is None else self.scale[within],
            None if self.scale_rate is None else self.scale_rate[within],
        )

    def amplitude_rates(self, model: Model) -> tuple[Complexes, Complexes]:
        """da/dt at the start and at the end of each step, (steps, modes)."""
        flow = shifted_flow(model, self.shift)
        later, moving = np.diff(self.time)[:, np.newaxis], (self.force_rate, self.frequency_rate)
        start = self._start_inputs()
        end = inputs_of(
            self.force + self.force_rate * later,
            self.frequency + self.frequency_rate * later,
            *moving,
            self.angle[1:],
        )
        if self.scale is not None and self.scale_rate is not None:
            end["limit_scale"] = self.scale + self.scale_rate * later[:, 0]
            end["limit_scale_rate"] = self.scale_rate
        return (
            rates(flow, start, self.amplitude_start),
            rates(flow, end, self.amplitude[1:]),
        )

    def _start_inputs(self) -> NDArray[np.void]:
        """The core's inputs at the start of each step, (steps,)."""
        moving = self.force_rate, self.frequency_rate
        start = inputs_of(self.force, self.frequency, *moving, self.angle[:-1])
        if self.scale is not None and self.scale_rate is not None:
            start["limit_scale"], start["limit_scale_rate"] = self.scale, self.scale_rate
        return start

    def resolved(self, model: Model) -> SlowTrajectory:
        """With further points where amplitudes do not move along a cubic from one to the next.

        As beside a combination resonance, in whose beat they go round within a long step.
        """
        flow, allowed = shifted_flow(model, self.shift), _BENT * np.abs(self.amplitude).max()
        bend = self._bend(flow)
        (bent,) = np.nonzero(bend > allowed)
        if not bent.size:
            return self
        found, off = self, min(float(bend.max() / allowed), _MOST_PARTS**_ORDER)
        parts = 2 ** max(1, round(np.log2(off) / _ORDER))
        while parts <= _MOST_PARTS:
            try:
                found = self._divided(flow, bent, parts)
            except SlipmodeError:  # steps that are far too long leave the friction table
                off = np.inf
            else:
                off = float(found._bend(flow).max())
            if off <= allowed:
                break
            parts *= 2
        return found

    def _bend(self, flow: kernel.SlowFlow) -> Floats:
        """By how much each step's cubic leaves the slow flow, were it as far off all along."""
        arrays, bend = self._steps(), np.empty(self.time.size - 1)
        steps = kernel.TrajectorySteps(bend.size, *(array.ctypes.data for array in arrays))
        status = kernel.lib.sm_trajectory_bend(flow, steps, bend.ctypes.data)
        kernel.check(status, "slow trajectory")
        return bend

    def _steps(self) -> tuple[np.ndarray, ...]:
        """Inputs and duration of steps, and the amplitudes that they start and end with."""
        start, end = self.amplitude_start, self.amplitude[1:]
        rows = self._start_inputs(), np.diff(self.time), start, end
        return tuple(np.ascontiguousarray(row) for row in rows)

    def _divided(
        self, flow: kernel.SlowFlow, steps: NDArray[np.intp], parts: int
    ) -> SlowTrajectory:
        """Some steps in so many parts."""
        modes = self.amplitude.shape[1]
        whole = [array[steps] for array in self._steps()]
        between = np.empty((steps.size, parts - 1, modes), dtype=complex)
        given = kernel.TrajectorySteps(steps.size, *(array.ctypes.data for array in whole))
        status = kernel.lib.sm_trajectory_divide(flow, given, parts, between.ctypes.data)
        kernel.check(status, "slow trajectory")
        counts = np.ones(self.time.size - 1, dtype=int)
        counts[steps] = parts
        of, first = np.repeat(np.arange(counts.size), counts), np.cumsum(counts) - counts
        part = np.arange(of.size) - first[of]
        later = part * (np.diff(self.time) / counts)[of]
        amplitude = np.vstack((self.amplitude[of], self.amplitude[-1:]))
        amplitude[np.nonzero(part)] = between.reshape(-1, modes)
        discontinuity = self.discontinuity
        if discontinuity is not None:
            discontinuity = np.where(part[:, np.newaxis] > 0, 0.0, discontinuity[of])
        time, elapsed = self.time[of] + later, later[:, np.newaxis]
        frequency_rate, force_rate = self.frequency_rate[of], self.force_rate[of]
        turned = (self.frequency[of] + 0.5 * frequency_rate * elapsed) * elapsed
        return SlowTrajectory(
            time=np.append(time, self.time[-1]),
            amplitude=amplitude,
            angle=np.vstack((self.angle[of] + turned, self.angle[-1:])),
            frequency=self.frequency[of] + frequency_rate * elapsed,
            frequency_rate=frequency_rate,
            force=self.force[of] + force_rate * elapsed,
            force_rate=force_rate,
            force_response=self.force_response,
            discontinuity=discontinuity,
            scale=None if self.scale is None else self.scale_at(time),
            scale_rate=None if self.scale_rate is None else self.scale_rate[of],
        )

    def effective(self, model: Model) -> Complexes:
        """Effective amplitudes at the contacts at every time, (steps + 1, modes)."""
        factor = coupling_factor(model.reduced, self.point_frequency)
        return np.asarray(factor * (self.amplitude + self.shift * self.point_force))

    def segments(self, model: Model) -> np.ndarray:
        """The steps as the core reads them."""
        duration = np.diff(self.time)
        segments = np.zeros(duration.size, dtype=kernel.SEGMENT)
        segments["start"], segments["duration"] = self.time[:-1], duration
        modes = slice(0, model.modes)
        segments["amplitude_start"][:, modes] = self.amplitude_start
        segments["amplitude_end"][:, modes] = self.amplitude[1:]
        start, end = self.amplitude_rates(model)
        segments["rate_start"][:, modes] = start
        segments["rate_end"][:, modes] = end
        segments["angle"][:, modes] = self.angle[:-1]
        segments["frequency"][:, modes] = self.frequency
        segments["frequency_rate"][:, modes] = self.frequency_rate
        return segments

    def contact_segments(self, segments: np.ndarray, reaction: Complexes) -> np.ndarray:
        """With effective amplitudes; `reaction` (steps + 1, orders, N_c) must outlive them.

        Amplitudes and reaction are divided by the scale of the limits, so that the motion is that
        of unscaled ones times the scale. At a jump of the scale contacts need a few periods to
        forget where they were.
        """
        segments = segments.copy()
        modes = slice(0, self.amplitude.shape[1])
        moving = self.shift * self.force_rate
        force_end = self.force + self.force_rate * np.diff(self.time)[:, np.newaxis]
        segments["amplitude_start"][:, modes] += self.shift * self.force
        segments["amplitude_end"][:, modes] += self.shift * force_end
        segments["rate_start"][:, modes] += moving
        segments["rate_end"][:, modes] += moving
        if self.scale is not None and self.scale_rate is not None:
            reaction /= self.scale_at(self.time)[:, np.newaxis, np.newaxis]
            ends = self.scale, self.scale + self.scale_rate * np.diff(self.time)
            for side, scale in zip(("start", "end"), ends, strict=True):
                growth = (self.scale_rate / scale)[:, np.newaxis]
                amplitude, rate = f"amplitude_{side}", f"rate_{side}"
                segments[rate] -= growth * segments[amplitude]
                for name in (amplitude, rate):
                    segments[name] /= scale[:, np.newaxis]
        segments["reaction_start"] = reaction.ctypes.data + reaction.strides[0] * np.arange(
            len(segments)
        )
        segments["reaction_end"] = segments["reaction_start"] + reaction.strides[0]
        return segments
