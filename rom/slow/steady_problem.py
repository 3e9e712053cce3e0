"""Steady motion at many points, each under a constant load: relaxation, Newton, integration."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.reduction.reduced import coupling_factor
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.slow_flow import (
    Balance,
    balance,
    inputs_of,
    rate_and_jacobian,
    shifted_flow,
)
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.model import Model

_RELAXATION_PASSES = 60
_NEWTON_PASSES = 25
_RELAXED = 1e-4  # of the table's range: from there on it is Newton's
_SETTLED = 1e-11  # of the table's range: Newton's next update would be rounding
_EDGE = 0.999  # of where amplitudes are held in the table
_CONVERGED = 1e-10  # of the forces in the amplitude equation


@dataclass(frozen=True, eq=False)
class SteadyProblem:
    """da/dt = 0 at points of a frequency and a constant excitation F_j exp(i phase_j) each."""

    model: Model
    excitation: Complexes
    shift: Complexes
    flow: kernel.SlowFlow
    inputs: NDArray[np.void]

    __repr__ = short_repr

    @classmethod
    def of(
        cls, model: Model, shift: Complexes, Omega: Floats, excitation: Complexes
    ) -> SteadyProblem:
        """At frequencies and excitations (points, modes), with `off_resonance_shift` (modes,)."""
        flow = shifted_flow(model, shift)
        return cls(model, excitation, shift, flow, inputs_of(excitation, Omega))

    def only(self, points: slice) -> Self:
        """The same at some of the points."""
        return replace(self, excitation=self.excitation[points], inputs=self.inputs[points])

    def balance(self, amplitude: Complexes, inputs: NDArray[np.void]) -> Balance:
        """What balances at amplitudes (points, modes) under inputs of as many points."""
        found = balance(self.flow, inputs, amplitude)
        outside = np.isnan(found.rate).any(axis=-1)
        if outside.any() and self._excited.any():
            raise SlipmodeError(
                f"amplitude: self-excited mode {_named(self._excited)} leaves the friction table, "
                f"whose range is {self.model.table.amplitude_range}; rom.limit_cycles says how "
                "far friction holds it"
            )
        if outside.any():
            effective = self.effective_modulus(amplitude, inputs)[outside]
            raise outside_table(effective, self.model.table)
        return found

    def effective_modulus(self, amplitude: Complexes, inputs: NDArray[np.void]) -> Floats:
        """Return the amplitudes at which the friction table is looked up, (points, modes).

        They include the direct action of the forces on the contacts, and the change of the
        coupling with the forcing frequency.
        """
        modes = slice(0, self.model.modes)
        force = inputs["force"][:, modes] * np.exp(1j * inputs["phase"][:, modes])
        factor = coupling_factor(self.model.reduced, inputs["frequency"][:, modes])
        return np.asarray(np.abs(factor * (amplitude + self.shift * force)))

    def relax(self) -> Complexes:
        """(stiffness - Q) a = F / 2 + Q shift F, half a step at a time from rest."""
        off_resonance = self.shift * self.excitation
        everywhere = np.arange(len(self.excitation))
        start = np.broadcast_to(1e-6 * self._range, self.excitation.shape)
        amplitude, moving = self.inside(start.astype(complex), everywhere), everywhere
        for _ in range(_RELAXATION_PASSES):
            before = amplitude[moving]
            now = self.balance(before, self.inputs.take(moving))
            Q = now.friction / (before + off_resonance[moving])
            balanced = (0.5 * self.excitation[moving] + Q * off_resonance[moving]) / (
                now.stiffness - Q
            )
            step = np.minimum(np.abs(balanced), self._range) - np.abs(before)
            modulus = np.maximum(np.abs(before) + 0.5 * step, 1e-12 * self._range)
            amplitude[moving] = self.inside(phasor(modulus, np.angle(balanced)), moving)
            moving = moving[(np.abs(step) > _RELAXED * self._range).any(axis=-1)]
            if moving.size == 0:
                break
        return np.where(self.excitation == 0.0, 0.0, amplitude)  # an unforced mode is at rest

    def polish(self, start: Complexes) -> Complexes:
        """Newton's method, inside the table, at all points that still move."""
        moving = np.arange(len(start))
        found = self.inside(start, moving)
        for _ in range(_NEWTON_PASSES):
            before = found[moving]
            rate, jacobian = rate_and_jacobian(self.flow, self.inputs.take(moving), before)
            update = np.linalg.solve(jacobian, rate[..., np.newaxis])[..., 0]
            after = self.inside(before - np.ascontiguousarray(update).view(complex), moving)
            found[moving] = after
            moving = moving[np.abs(after - before).max(axis=-1) > _SETTLED * self._range.max()]
            if moving.size == 0:
                break
        return found

    def imbalance(self, amplitude: Complexes) -> Floats:
        """Unbalanced force relative to the forces in the amplitude equations, (points,)."""
        now = self.balance(amplitude, self.inputs)
        elastic = np.abs(now.stiffness * amplitude).max(axis=-1)
        scale = 0.5 * np.abs(self.excitation).max(axis=-1) + elastic + 1e-300
        return np.asarray(np.abs(now.mass * now.rate).max(axis=-1) / scale)

    def is_steady(self, amplitude: Complexes) -> Flags:
        """Where the slow flow stands still and, with self-excited modes, returns to that."""
        stands = self.imbalance(amplitude) <= _CONVERGED
        if self._excited.any():
            _, jacobian = rate_and_jacobian(self.flow, self.inputs, amplitude)
            stands &= np.linalg.eigvals(jacobian).real.max(axis=-1) < 0.0
        return np.asarray(stands)

    def from_rest(self) -> Complexes:
        """Integrate the slow flow of one point from rest until it stands still, (modes,).

        Slow, but it cannot miss.
        """
        from scipy.integrate import solve_ivp  # takes longer to import than many a table

        slowest = np.abs(self.model.reduced.modal_damping).min()
        if slowest <= 0.0:
            slowest = 1e-3 * self.model.reduced.frequency.min()
        y = np.zeros(2 * self.model.modes)
        free = self._excited & (self.excitation[0] == 0.0)

        outside = np.zeros((1, self.model.modes), dtype=complex)

        def rate(_: float, z: Floats) -> Floats:
            # NaN where a trial stage leaves the table: a shorter step follows.
            if np.isnan(z).any():
                return z
            amplitude = z.view(complex)[np.newaxis]
            now: Floats = balance(self.flow, self.inputs, amplitude).rate[0].view(float)
            if np.isnan(now).any():
                outside[:] = amplitude
            return now

        for _ in range(20):
            path = solve_ivp(rate, (0.0, 10.0 / slowest), y, rtol=1e-8, atol=1e-12)
            if not path.success:
                self.balance(outside, self.inputs)  # raises, for the path leaves the table
            y = path.y[:, -1]
            point = self.polish(y.view(complex)[np.newaxis])
            if self.is_steady(point)[0]:
                found: Complexes = point[0]
                return found
            if free.any() and self.imbalance(point)[0] <= _CONVERGED:
                raise SlipmodeError(
                    f"aerodynamics: mode {_named(free)} is self-excited and not forced: it does "
                    "not stay at rest; rom.limit_cycles finds its limit cycles"
                )
        held = ""
        if self._excited.any():
            held = f": self-excited mode {_named(self._excited)} is not held by its force there"
        Omega = self.inputs["frequency"][0, : self.model.modes]
        raise SlipmodeError(f"frequency: no steady state found at {Omega} rad/s{held}")

    def inside(self, amplitude: Complexes, points: NDArray[np.intp]) -> Complexes:
        """The amplitudes, scaled back where the effective ones would leave the table."""
        off_resonance = self.shift * self.excitation[points]
        modulus = np.abs(amplitude + off_resonance)
        over = modulus > self._range
        factor = np.divide(self._range, modulus, out=np.ones(modulus.shape), where=over)
        return np.where(over, factor * (amplitude + off_resonance) - off_resonance, amplitude)

    def at_edge(self, amplitude: Complexes) -> Flags:
        """Which effective amplitudes `inside` holds in the table, (points, modes)."""
        modulus = np.abs(amplitude + self.shift * self.excitation)
        return np.asarray(modulus >= _EDGE * self._range)

    @property
    def _excited(self) -> Flags:
        """Self-excited modes, (modes,)."""
        return np.asarray(self.model.reduced.modal_damping < 0.0)

    @property
    def _range(self) -> Floats:
        """A little inside the table, so that the coupling ratio has room."""
        return 0.998 * self.model.table.amplitude_range


def _named(modes: Flags) -> str:
    """A, B, or both."""
    return " and ".join("AB"[j] for j in np.flatnonzero(modes))
