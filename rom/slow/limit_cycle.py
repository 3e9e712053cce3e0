"""Limit cycles of self-excited modes: friction takes what aerodynamics put in.

An unforced mode oscillates at a frequency of its own, which is an unknown beside its amplitude:

    omega_j^2 - Omega_j^2 + i gamma_j Omega_j = Q_j(|a_A|, |a_B|),

the imaginary part says how large it grows, the real part how fast it turns. A forced mode beside
it has its amplitude equation as in any steady state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.slow_flow import balance, inputs_of, rate_and_jacobian, shifted_flow
from slipmode.rom.table.model import Model
from slipmode.rom.table.quasi_static import SteadyStates, check_force_patterns
from slipmode.rom.validity import (
    carrier_range,
    check_carriers,
    forcing_findings,
    friction_findings,
    warn,
)

_SCANNED = {1: 400, 2: 64}  # amplitudes of each self-excited mode, by their number
_PASSES = 60
_INSIDE = 0.998  # of the table, so that the coupling ratio has room
_CONVERGED = 1e-9  # of the elastic force at the largest amplitudes
_SAME = 1e-6  # relative distance of limit cycles that are one


@dataclass(frozen=True, eq=False)
class LimitCycle:
    """x = 2 Re(sum_j mode_shape_j a_j exp(i Omega_j t)) plus the contacts' share.

    Attributes
    ----------
    amplitude : (modes,) complex ndarray
        a_j [kg^1/2 m]; of a self-excited mode real, for its phase is arbitrary.
    frequency : (modes,) ndarray
        Omega_j [rad/s]: of the force, or of its own.
    growth : float
        Of a small deviation [1/s], of that which grows fastest or decays slowest.
    """

    amplitude: Complexes
    frequency: Floats
    growth: float

    __repr__ = short_repr

    @property
    def stable(self) -> bool:
        """Whether motion near it tends to it; from an unstable one it decays or grows away."""
        return self.growth < 0.0


def limit_cycles(
    model: Model,
    frequency: Sequence[float | None] | None = None,
    force: Forces | None = None,
    phase: ArrayLike = 0.0,
) -> tuple[LimitCycle, ...]:
    """Every limit cycle within the friction table, by ascending amplitude.

    Friction that slips freely no longer grows with the amplitude: past a stable limit cycle there
    often is an unstable one, beyond which the mode grows without bound.

    Parameters
    ----------
    model : Model
        Of which an unforced mode is self-excited: reduced with `aerodynamics`. The nearer its
        carrier to the frequency of the limit cycle, the more exact: `rom.reduce(..., carrier=)`.
    frequency : sequence of float, optional
        Forcing frequencies [rad/s], one per mode; those of unforced modes do not matter.
    force : one {DOF: amplitude} or (n,) array_like per mode, optional
        Force amplitudes [N] as in `steady`; {} of an unforced mode. Default: nothing is forced.
    phase : float or (modes,) array_like
        Phases of the forces [rad].

    Returns
    -------
    tuple of LimitCycle
        Where two modes are self-excited also those in which one of them is at rest. Empty if none
        is inside the table. Of a forced mode that has several steady states, with the one that is
        reached from rest.

    Raises
    ------
    SlipmodeError
        If no unforced mode is self-excited, or the frequency of a forced one is none that its
        slow flow can follow.

    Warns
    -----
    ValidityWarning
        Where friction or the force strain what the method assumes.
    """
    force = [{}] * model.modes if force is None else force
    applied = AppliedForces.of(model.reduced, force)
    excitation = applied.excitation(phase)
    forced = excitation != 0.0
    excited = np.flatnonzero(~forced & (model.reduced.modal_damping < 0.0))
    if not excited.size:
        raise SlipmodeError(
            "force: no unforced mode is self-excited, so there is no limit cycle; give rom.reduce "
            "aerodynamics with an imaginary part that makes its modal damping negative"
        )
    Omega = _frequencies(model, frequency, forced)
    warn(forcing_findings(model.reduced, Omega, forced))
    flow = shifted_flow(model, applied.shift)
    some = chain.from_iterable(combinations(excited, n) for n in range(1, excited.size + 1))
    found = [
        cycle
        for moving in some
        for cycle in _Cycling(
            model, flow, excitation, applied.shift * excitation, Omega, np.array(moving)
        ).solutions()
    ]
    if found:
        largest = np.max([np.abs(cycle.amplitude) for cycle in found], axis=0)
        amplitude = np.array([cycle.amplitude for cycle in found])
        every = np.tile(excitation, (len(found), 1))
        check_force_patterns(model, applied, SteadyStates.of(applied, amplitude, every))
        warn(friction_findings(model.reduced, model.law, largest))
        warn(model.detuning_findings(np.array([cycle.frequency for cycle in found])))
    return tuple(sorted(found, key=lambda cycle: np.abs(cycle.amplitude[excited]).max()))


def _frequencies(model: Model, frequency: Sequence[float | None] | None, forced: Flags) -> Floats:
    """Forcing frequencies, natural ones of unforced modes (modes,)."""
    natural = model.reduced.frequency
    if frequency is None and not forced.any():
        return natural.copy()
    given = as_floats("frequency", np.nan if frequency is None else frequency)
    if given.shape != natural.shape or not np.isfinite(given[forced]).all():
        raise SlipmodeError(
            f"frequency: must be {natural.size} numbers [rad/s], finite for each mode that is "
            f"forced, got {frequency}"
        )
    Omega = np.where(forced, given, natural)
    check_carriers(model.reduced, Omega, forced)
    return Omega


@dataclass(frozen=True, eq=False)
class _Cycling:
    """Some modes in limit cycles, forced ones beside them, the others at rest."""

    model: Model
    flow: kernel.SlowFlow
    excitation: Complexes
    off_resonance: Complexes  # (modes,), what the forces add to the amplitudes at the contacts
    Omega: Floats
    moving: np.ndarray  # numbers of the modes in limit cycles

    def solutions(self) -> Iterator[LimitCycle]:
        """Each once."""
        known: list[Complexes] = []
        for amplitude, Omega in self._starts():
            solved = self._polished(amplitude, Omega)
            if solved is None:
                continue
            a, frequency = solved
            if all(np.abs(a - other).max() > _SAME * np.abs(a).max() for other in known):
                known.append(a)
                yield LimitCycle(a, frequency, self._growth(a, frequency))

    def _starts(self) -> Iterator[tuple[Complexes, Floats]]:
        """Amplitudes and frequencies (modes,) near which no mode gains or loses energy."""
        n, modes = _SCANNED[self.moving.size], self.moving.size
        axes = [self._range[j] * np.arange(1, n + 1) / n for j in self.moving]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, modes)
        a, Omega, net = self._settled(points)
        cells = net.reshape(*[n] * modes, modes)
        for axis in range(modes):  # least and largest of the corners of each cell
            first, last = (np.delete(cells, k, axis=axis) for k in (-1, 0))
            cells = np.concatenate((first, last), axis=-1)
        corners = cells.reshape(-1, 2**modes, modes)
        crossed = np.all((corners.min(axis=1) <= 0.0) & (corners.max(axis=1) >= 0.0), axis=-1)
        corner = np.arange(n**modes).reshape([n] * modes)[(slice(-1),) * modes].ravel()
        for k in corner[crossed]:
            yield a[k], Omega[k]

    def _settled(self, moduli: Floats) -> tuple[Complexes, Floats, Floats]:
        """Forced modes and frequencies for amplitudes (points, moving) that are held.

        Returns
        -------
        amplitude : (points, modes) complex ndarray
        Omega : (points, modes) ndarray
        net : (points, moving) ndarray
            Net damping force per amplitude of the modes in limit cycles [rad^2/s^2].
        """
        count, omega = len(moduli), self.model.reduced.frequency[self.moving]
        forced = self.excitation != 0.0
        a = np.zeros((count, self.model.modes), dtype=complex)
        a[:, forced] = 1e-6 * self._range[forced]
        a[:, self.moving] = moduli
        Omega = np.tile(self.Omega, (count, 1))
        low, high = np.array([carrier_range(float(each)) for each in omega]).T
        for _ in range(_PASSES):
            now = balance(self.flow, inputs_of(self._forces(count), Omega), a)
            Q = now.friction[:, self.moving] / moduli
            square = np.nan_to_num(omega**2 - Q.real)
            Omega[:, self.moving] = np.clip(np.sqrt(np.maximum(square, 0.0)), low, high)
            a[:, forced] = self._relaxed(now.stiffness, now.friction, a)[:, forced]
        net = now.stiffness[:, self.moving].imag - Q.imag
        return a, Omega, net

    def _relaxed(self, stiffness: Complexes, friction: Complexes, a: Complexes) -> Complexes:
        """Half a step towards (stiffness - Q) a = F / 2 + Q shift F."""
        effective = a + self.off_resonance
        Q = np.divide(friction, effective, out=np.zeros_like(a), where=effective != 0.0)
        balanced = (0.5 * self.excitation + Q * self.off_resonance) / (stiffness - Q)
        modulus = 0.5 * (np.abs(a) + np.minimum(np.abs(balanced), self._range))
        room = np.maximum(self._range - np.abs(self.off_resonance), 0.0)
        return np.asarray(np.minimum(modulus, room) * np.exp(1j * np.angle(balanced)))

    def _polished(self, a: Complexes, Omega: Floats) -> tuple[Complexes, Floats] | None:
        """A solution close by, amplitudes and frequencies (modes,); None: there is none."""
        from scipy.optimize import root  # takes a while to import

        natural, most = self.model.reduced.frequency, self._range
        solved = self.moving.tolist() + np.flatnonzero(self.excitation).tolist()
        cycles = self.moving.size

        def unpacked(z: Floats) -> tuple[Complexes, Floats]:
            pairs, now, frequency = z.reshape(-1, 2), a * 0.0, Omega.copy()
            now[solved] = most[solved] * (pairs[:, 0] + 1j * pairs[:, 1])
            now[self.moving] = most[self.moving] * pairs[:cycles, 0]
            frequency[self.moving] = natural[self.moving] * pairs[:cycles, 1]
            return now, frequency

        def unbalanced(z: Floats) -> Floats:
            now, frequency = unpacked(z)
            inputs = inputs_of(self._forces(1), frequency[np.newaxis])
            found = balance(self.flow, inputs, now[np.newaxis])
            force = ((found.mass * found.rate)[0] / (natural**2 * most))[solved]
            return np.stack((force.real, force.imag), axis=-1).ravel()

        start = np.stack(((a / most).real, (a / most).imag), axis=-1)
        start[self.moving, 1] = (Omega / natural)[self.moving]
        z = root(unbalanced, start[solved].ravel(), options={"xtol": 1e-13}).x
        now, frequency = unpacked(z)
        if not np.abs(unbalanced(z)).max() <= _CONVERGED or np.any(now[self.moving].real <= 0.0):
            return None
        return now, frequency

    def _growth(self, a: Complexes, Omega: Floats) -> float:
        """Of small deviations; a shift of phase of the cycling modes neither grows nor decays."""
        inputs = inputs_of(self._forces(1), Omega[np.newaxis])
        _, jacobian = rate_and_jacobian(self.flow, inputs, a[np.newaxis])
        kept = np.delete(np.arange(2 * a.size), 2 * self.moving + 1)
        return float(np.linalg.eigvals(jacobian[0][np.ix_(kept, kept)]).real.max())

    def _forces(self, points: int) -> Complexes:
        return np.tile(self.excitation, (points, 1))

    @property
    def _range(self) -> Floats:
        return _INSIDE * self.model.table.amplitude_range
