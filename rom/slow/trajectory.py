"""The slow trajectory: amplitudes and carriers of a run, for the reconstruction of motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import coupling_factor
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.slow_flow import inputs_of, rates, shifted_flow
from slipmode.rom.table.model import Model

_MOST_PARTS = 256  # of a step
_PATH_ERROR = 1e-5  # relative, far below the deviations that are allowed


@frozen
class SlowTrajectory:
    """Hold amplitudes, carriers and forces of a simulation in slow time.

    Inputs are linear between successive times.

    Attributes
    ----------
    time : (steps + 1,) ndarray
        Times [s], ascending.
    amplitude : (steps + 1, modes) complex ndarray
        Amplitudes a_j [kg^1/2 m].
    angle : (steps + 1, modes) ndarray
        Carrier phases theta_j [rad], modulo 2 pi.
    frequency, frequency_rate : (steps, modes) ndarray
        Carrier frequencies [rad/s] and their rates [rad/s^2] at the start of each step.
    force, force_rate : (steps, modes) complex ndarray
        Modal forces F_j exp(i psi_j) [N kg^-1/2] and their rates [N kg^-1/2 s^-1] at the start of
        each step.
    force_response : AppliedForces, optional
        Force patterns, in any scale, for the quasi-static response of contacts and other modes.
        Default: no such response.
    discontinuity : (steps, modes) complex ndarray, optional
        Jumps of the amplitudes at the start of each step due to jumps of the forces [kg^1/2 m].
        Default: none.
    scale, scale_rate : (steps,) ndarray, optional
        Factor on friction limits and preloads of the model [-] and its rate [1/s], at the start of
        each step. Default: constant 1.
    """

    time: Floats
    amplitude: Complexes
    angle: Floats
    frequency: Floats
    frequency_rate: Floats
    force: Complexes
    force_rate: Complexes
    force_response: AppliedForces | None = None
    discontinuity: Complexes | None = None
    scale: Floats | None = None
    scale_rate: Floats | None = None

    @property
    def amplitude_start(self) -> Complexes:
        """Amplitudes at the start of each step, after its jump, (steps, modes) [kg^1/2 m]."""
        before = self.amplitude[:-1]
        return before if self.discontinuity is None else before + self.discontinuity

    @property
    def shift(self) -> Complexes | float:
        """Shift s_j of the effective amplitudes per modal force, (modes,) [s^2], or 0."""
        return self.force_response.shift if self.force_response else 0.0

    @property
    def point_force(self) -> Complexes:
        """Modal forces F_j exp(i psi_j) at all times, (steps + 1, modes) [N kg^-1/2]."""
        last = self.force[-1] + self.force_rate[-1] * (self.time[-1] - self.time[-2])
        return np.vstack((self.force, last))

    @property
    def point_frequency(self) -> Floats:
        """Carrier frequencies at all times, (steps + 1, modes) [rad/s]."""
        last = self.frequency[-1] + self.frequency_rate[-1] * (self.time[-1] - self.time[-2])
        return np.vstack((self.frequency, last))

    @property
    def limit_scale(self) -> tuple[Floats, Floats]:
        """Factor on limits and preloads [-] at the start of each step, and its rate [1/s]."""
        steps = self.time.size - 1
        scale = np.ones(steps) if self.scale is None else self.scale
        return scale, np.zeros(steps) if self.scale_rate is None else self.scale_rate

    def scale_at(self, times: Floats) -> Floats:
        """Return the factor on friction limits and preloads at given times, after jumps.

        Parameters
        ----------
        times : (n,) ndarray
            Times [s].

        Returns
        -------
        (n,) ndarray
            Factor [-].
        """
        scale, rate = self.limit_scale
        k = np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, scale.size - 1)
        return np.asarray(scale[k] + rate[k] * (times - self.time[k]))

    def between(self, start: float, end: float) -> SlowTrajectory:
        """Return the part of the trajectory whose steps overlap an interval.

        Parameters
        ----------
        start, end : float
            Ends of the interval [s].

        Returns
        -------
        SlowTrajectory
            Whole steps that overlap the interval.
        """
        steps = self.time.size - 1
        first = min(max(int(np.searchsorted(self.time, start, side="right")) - 1, 0), steps - 1)
        last = min(max(int(np.searchsorted(self.time, end, side="left")), first + 1), steps)
        parts: dict[str, Any] = {
            # These fields have one row more than there are steps
            name: value[first : last + (name in ("time", "amplitude", "angle"))]
            for name, value in vars(self).items()
            if isinstance(value, np.ndarray)
        }
        return replace(self, **parts)

    def amplitude_rates(self, model: Model) -> tuple[Complexes, Complexes]:
        """Return the rates of the amplitudes by the slow flow.

        Parameters
        ----------
        model : Model
            Model of the simulation.

        Returns
        -------
        start, end : (steps, modes) complex ndarray
            da_j/dt at the start and at the end of each step [kg^1/2 m/s].
        """
        flow = shifted_flow(model, self.shift)
        return (
            rates(flow, self._inputs(0.0), self.amplitude_start),
            rates(flow, self._inputs(1.0), self.amplitude[1:]),
        )

    def _inputs(self, part: float | Floats, steps: Any = slice(None)) -> NDArray[np.void]:
        """Return the core's inputs after a part (0 to 1) of steps, (steps,)."""
        later = part * np.diff(self.time)[steps]
        elapsed, frequency = later[:, np.newaxis], self.frequency[steps]
        sweep, force_rate = self.frequency_rate[steps], self.force_rate[steps]
        inputs = inputs_of(
            self.force[steps] + force_rate * elapsed,
            frequency + sweep * elapsed,
            force_rate,
            sweep,
            self.angle[:-1][steps] + (frequency + 0.5 * sweep * elapsed) * elapsed,
        )
        scale, rate = (each[steps] for each in self.limit_scale)
        inputs["limit_scale"], inputs["limit_scale_rate"] = scale + rate * later, rate
        return inputs

    def resolved(self, model: Model) -> SlowTrajectory:
        """Return the trajectory with more points where it changes within a step.

        Steps are divided where cubic interpolation deviates from the slow flow. This happens near
        a combination resonance, whose beat may be shorter than a step.

        Parameters
        ----------
        model : Model
            Model of the simulation.

        Returns
        -------
        SlowTrajectory
            Trajectory whose cubics deviate by at most 3e-4 of the largest amplitude.
        """
        flow, allowed = shifted_flow(model, self.shift), 3e-4 * np.abs(self.amplitude).max()
        deviation = self._deviation(flow)
        (large,) = np.nonzero(deviation > allowed)
        found, parts = self, 1
        path = self._paths(flow, large) if large.size else None
        while path is not None and deviation.max() > allowed and parts < _MOST_PARTS:
            parts *= 2
            found = self._divided(large, path(np.arange(parts + 1) / parts))
            deviation = found._deviation(flow)
        return found

    def _deviation(self, flow: kernel.Structure) -> Floats:
        """Return the deviation of each step's cubic from the slow flow, (steps,).

        Infinite where the cubic leaves the friction table.
        """
        duration = np.diff(self.time)[:, np.newaxis]
        start, end = self.amplitude_start, self.amplitude[1:]
        leaving = duration * rates(flow, self._inputs(0.0), start, may_leave=True)
        arriving = duration * rates(flow, self._inputs(1.0), end, may_leave=True)
        found = np.zeros(len(start))
        for r in (0.25, 0.6):  # not commensurate, so that no beat hides between them
            rest, change = 1.0 - r, end - start
            cubic = start + r**2 * (3.0 - 2.0 * r) * change
            cubic += r * rest * (rest * leaving - r * arriving)
            slope = 6.0 * r * rest * change
            slope += rest * (1.0 - 3.0 * r) * leaving - r * (2.0 - 3.0 * r) * arriving
            inside = np.isfinite(cubic).all(axis=1)
            rate = np.full_like(cubic, np.nan)
            rate[inside] = rates(flow, self._inputs(r, inside), cubic[inside], may_leave=True)
            found = np.maximum(found, np.abs(duration * rate - slope).max(axis=1))
        return np.where(np.isnan(found), np.inf, found)

    def _paths(
        self, flow: kernel.Structure, steps: NDArray[np.intp]
    ) -> Callable[[Floats], Complexes]:
        """Return the amplitudes (points, steps, modes) of the slow flow at parts of some steps."""
        start, h = self.amplitude_start[steps], np.diff(self.time)[steps, np.newaxis]

        def slope(part: float, y: Complexes) -> Complexes:
            now = np.nan_to_num(y.reshape(start.shape))
            return (h * rates(flow, self._inputs(part, steps), now, may_leave=True)).ravel()

        scale = _PATH_ERROR * np.abs(start).max()
        options = {"rtol": _PATH_ERROR, "atol": scale, "dense_output": True}
        path: Any = scipy.integrate.solve_ivp(
            slope, (0.0, 1.0), start.ravel(), method="RK45", **options
        )
        return lambda parts: np.asarray(path.sol(parts)).T.reshape(-1, *start.shape)

    def _divided(self, steps: NDArray[np.intp], path: Complexes) -> SlowTrajectory:
        """Return the trajectory with some steps divided at a path (parts + 1, steps, modes)."""
        parts, modes = len(path) - 1, self.amplitude.shape[1]
        # it ends where the trajectory does
        share = np.arange(parts)[:, np.newaxis, np.newaxis] / parts
        between = path[:-1] + share * (self.amplitude[1:][steps] - path[-1])
        counts = np.ones(self.time.size - 1, dtype=int)
        counts[steps] = parts
        of, first = np.repeat(np.arange(counts.size), counts), np.cumsum(counts) - counts
        number = np.arange(of.size) - first[of]  # of a part in its step
        part = number / counts[of]
        inputs = self._inputs(part, of)
        elapsed = (part * np.diff(self.time)[of])[:, np.newaxis]
        amplitude = np.vstack((self.amplitude[of], self.amplitude[-1:]))
        amplitude[np.nonzero(number)] = between[1:].swapaxes(0, 1).reshape(-1, modes)
        discontinuity = self.discontinuity
        if discontinuity is not None:
            discontinuity = np.where(part[:, np.newaxis] > 0, 0.0, discontinuity[of])
        return replace(
            self,
            time=np.append(self.time[of] + elapsed[:, 0], self.time[-1]),
            amplitude=amplitude,
            angle=np.vstack((inputs["angle"][:, :modes], self.angle[-1:])),
            frequency=inputs["frequency"][:, :modes],
            frequency_rate=self.frequency_rate[of],
            force=self.force[of] + self.force_rate[of] * elapsed,
            force_rate=self.force_rate[of],
            discontinuity=discontinuity,
            scale=inputs["limit_scale"],
            scale_rate=inputs["limit_scale_rate"],
        )

    def effective(self, model: Model) -> Complexes:
        """Return the effective amplitudes at the contacts, r_j (a_j + s_j F_j exp(i psi_j)).

        Parameters
        ----------
        model : Model
            Model of the simulation.

        Returns
        -------
        (steps + 1, modes) complex ndarray
            Effective amplitudes z_j at all times [kg^1/2 m].
        """
        factor = coupling_factor(model.reduced, self.point_frequency)
        return np.asarray(factor * (self.amplitude + self.shift * self.point_force))

    def segments(self, model: Model) -> np.ndarray:
        """Return the steps as the compiled core reads them.

        Parameters
        ----------
        model : Model
            Model of the simulation.

        Returns
        -------
        (steps,) structured ndarray
            Start, duration, amplitudes, phases and frequencies of each step.
        """
        duration = np.diff(self.time)
        segments = np.zeros(duration.size, dtype=kernel.SEGMENT)
        segments["start"], segments["duration"] = self.time[:-1], duration
        modes = slice(0, model.modes)
        start, end = self.amplitude_rates(model)
        for name, value in (
            ("amplitude_start", self.amplitude_start),
            ("amplitude_end", self.amplitude[1:]),
            ("rate_start", start),
            ("rate_end", end),
        ):
            segments[name].view(complex)[:, modes] = value
        segments["angle"][:, modes] = self.angle[:-1]
        segments["frequency"][:, modes] = self.frequency
        segments["frequency_rate"][:, modes] = self.frequency_rate
        return segments

    def contact_segments(self, segments: np.ndarray, reaction: Complexes) -> np.ndarray:
        """Return the steps with effective amplitudes, relative to the factor on friction limits.

        The contact motion is the factor times the motion computed from this result. After a jump
        of the factor, contacts need a few periods to forget their displacement.

        Parameters
        ----------
        segments : (steps,) structured ndarray
            Result of `segments`.
        reaction : (steps + 1, orders, N_c) complex ndarray
            Forces of the modes on the contacts [N]. They are divided by the factor in place. The
            result refers to this array.

        Returns
        -------
        (steps,) structured ndarray
            Steps for the integration of the contact motion.
        """
        segments = segments.copy()
        modes = slice(0, self.amplitude.shape[1])
        later = np.diff(self.time)
        scale, scale_rate = self.limit_scale
        reaction /= self.scale_at(self.time)[:, np.newaxis, np.newaxis]
        for side, elapsed in (("start", 0.0 * later), ("end", later)):
            amplitude, rate = (
                segments[f"{name}_{side}"].view(complex) for name in ("amplitude", "rate")
            )
            force = self.force + self.force_rate * elapsed[:, np.newaxis]
            amplitude[:, modes] += self.shift * force
            rate[:, modes] += self.shift * self.force_rate
            factor = (scale + scale_rate * elapsed)[:, np.newaxis]
            rate -= scale_rate[:, np.newaxis] / factor * amplitude
            amplitude /= factor
            rate /= factor
        segments["reaction_start"] = reaction.ctypes.data + reaction.strides[0] * np.arange(
            len(segments)
        )
        segments["reaction_end"] = segments["reaction_start"] + reaction.strides[0]
        return segments
