"""Limit cycles of self-excited modes, in which friction dissipates the aerodynamic power.

The amplitude and the frequency of an unforced mode are both unknown:

    omega_j^2 - Omega_j^2 + i gamma_j Omega_j = Q_j(|a_A|, |a_B|).

The imaginary part determines the amplitude, the real part the frequency. A forced mode has its
amplitude equation as in a steady state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, Forces, phasor
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import TableError, off_carrier_findings
from slipmode.rom.slow.slow_flow import ForcedFlow, inputs_of
from slipmode.rom.slow.steady_points import INSIDE
from slipmode.rom.table.model import Model
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import (
    carrier_range,
    check_carriers,
    forcing_findings,
    friction_findings,
    warn,
)

# Largest distance of a forced mode from balance, relative to the range, from which Newton's
# method continues.
_STEADY = 1e-4


@frozen
class LimitCycle:
    """Hold a limit cycle x = 2 Re(sum_j mode_shape_j a_j exp(i Omega_j t)) + contact_shapes x_c.

    Attributes
    ----------
    amplitude : (modes,) complex ndarray
        Amplitudes a_j [kg^1/2 m]; real for a self-excited mode, whose phase is arbitrary.
    frequency : (modes,) ndarray
        Frequencies Omega_j of the vibration [rad/s]; the forcing frequency for a forced mode.
    growth : float
        Largest growth rate of small deviations [1/s].
    """

    amplitude: Complexes
    frequency: Floats
    growth: float

    @property
    def stable(self) -> bool:
        """Whether small deviations from the limit cycle decay."""
        return self.growth < 0.0


def limit_cycles(
    model: Model,
    frequency: Sequence[float | None] | None = None,
    force: Forces | None = None,
    phase: ArrayLike = 0.0,
) -> tuple[LimitCycle, ...]:
    """Return the limit cycles of self-excited modes within the friction table.

    Parameters
    ----------
    model : Model
        Model with an unforced self-excited mode, from `rom.reduce` with `aerodynamics`. Its
        carrier should be near the frequency of the limit cycle.
    frequency : sequence of float, optional
        Forcing frequencies [rad/s], one per mode, ignored for unforced modes.
    force : one {DOF: amplitude} or (n,) array_like per mode, optional
        Force amplitudes [N]; {} for an unforced mode. Default: no mode is forced.
    phase : float or (modes,) array_like, default 0.0
        Phases of the forces [rad].

    Returns
    -------
    tuple of LimitCycle
        Limit cycles by ascending amplitude; empty if none is inside the table. With two
        self-excited modes, limit cycles with one mode at rest are included. A forced mode is in
        the steady state that is reached from rest.

    Raises
    ------
    SlipmodeError
        If no unforced mode is self-excited, or the slow flow cannot follow a forcing frequency. If
        forced modes do not become steady inside the friction table at any amplitude.

    Warns
    -----
    ValidityWarning
        If friction or a force violates an assumption of the method. If forced modes do not become
        steady inside the friction table at some amplitudes, so that limit cycles may be missing.

    Notes
    -----
    The limit cycles solve omega_j^2 - Omega_j^2 + i gamma_j Omega_j = Q_j, see "Self-excited
    modes" in docs/theory.md. The damping of sliding friction decreases with the amplitude. Above a
    stable limit cycle there is therefore often an unstable one, beyond which the amplitude grows
    without bound.

    Examples
    --------
    A self-excited mode with a stable and an unstable limit cycle:

    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,), aerodynamics=[-0.02j], carrier=[0.98])
    >>> model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(12.0,))
    >>> [(abs(cycle.amplitude).round(2), cycle.stable) for cycle in rom.limit_cycles(model)]
    [(array([1.26]), True), (array([4.69]), False)]
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
    flow = ForcedFlow.of(model, Omega[np.newaxis], excitation, applied.shift)
    some = chain.from_iterable(combinations(excited, n) for n in range(1, excited.size + 1))
    found = [cycle for moving in some for cycle in _Cycling(flow, np.array(moving)).solutions()]
    if found:
        largest = np.max([np.abs(cycle.amplitude) for cycle in found], axis=0)
        amplitude = np.array([cycle.amplitude for cycle in found])
        every = np.tile(excitation, (len(found), 1))
        check_force_patterns(model, applied, amplitude, every)
        warn(friction_findings(model.reduced, model.law, largest))
        Omega = np.array([cycle.frequency for cycle in found])
        cycles = ForcedFlow.of(model, Omega, every, applied.shift)
        change = TableError.of(cycles, amplitude, applied)
        balance = np.abs(model.reduced.modal_damping * Omega * amplitude)[change.at]
        off = np.abs(change.measured)
        off = np.where(off <= model.accuracy.total * change.scale[change.at], 0.0, off)
        share = np.divide(off, balance, out=np.zeros_like(off), where=balance > 0.0)
        worst = float(np.nan_to_num(share, nan=np.inf).max(initial=0.0))
        apart = Omega / model.reduced.carrier - 1.0
        warn(off_carrier_findings(model.accuracy.tolerance, worst, apart, "the damping"))
    return tuple(sorted(found, key=lambda cycle: np.abs(cycle.amplitude[excited]).max()))


def _frequencies(model: Model, frequency: Sequence[float | None] | None, forced: Flags) -> Floats:
    """Return forcing frequencies, and natural ones of unforced modes (modes,)."""
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


def _check_steady(steady: Flags, moduli: Floats) -> None:
    """Refuse or report amplitudes (points, moving) at which forced modes are not steady."""
    if steady.all():
        return
    reason = "forced modes do not become steady inside the friction table"
    advice = "tabulate a larger range, or reduce the force"
    if not steady.any():
        raise SlipmodeError(f"force: {reason} at any amplitude; {advice}")
    apart = np.linalg.norm(moduli[~steady], axis=1)
    where = f"at amplitudes of {apart.min():.3g} to {apart.max():.3g} kg^1/2 m"
    warn([Finding("limit cycles", "may be missing", f"{reason} {where}; {advice}", "warning")])


@dataclass(frozen=True, eq=False)
class _Cycling:
    """Some modes in limit cycles, with forced ones, and the others at rest."""

    flow: ForcedFlow  # at one point
    moving: NDArray[np.intp]  # numbers of the modes in limit cycles

    def solutions(self) -> Iterator[LimitCycle]:
        """Yield each limit cycle once."""
        known: list[Complexes] = []
        for amplitude, Omega in self._starts():
            solved = self._solved(amplitude, Omega)
            if solved is None:
                continue
            a, frequency = solved
            if all(np.abs(a - other).max() > 1e-6 * np.abs(a).max() for other in known):
                known.append(a)
                yield LimitCycle(a, frequency, self._growth(a, frequency))

    def _starts(self) -> Iterator[tuple[Complexes, Floats]]:
        """Yield amplitudes and frequencies (modes,) near which no mode gains or loses energy."""
        modes = self.moving.size
        n = 400 if modes == 1 else 64  # amplitudes of each mode
        axes = [self._range[j] * np.arange(1, n + 1) / n for j in self.moving]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, modes)
        a, Omega, net = self._with_forced_modes(points)
        cells = net.reshape(*[n] * modes, modes)
        for axis in range(modes):  # least and largest of the corners of each cell
            first, last = (np.delete(cells, k, axis=axis) for k in (-1, 0))
            cells = np.concatenate((first, last), axis=-1)
        corners = cells.reshape(-1, 2**modes, modes)
        crossed = np.all((corners.min(axis=1) <= 0.0) & (corners.max(axis=1) >= 0.0), axis=-1)
        corner = np.arange(n**modes).reshape([n] * modes)[(slice(-1),) * modes].ravel()
        for k in corner[crossed]:
            yield a[k], Omega[k]

    def _with_forced_modes(self, moduli: Floats) -> tuple[Complexes, Floats, Floats]:
        """Return amplitudes and frequencies for amplitudes (points, moving) in limit cycles.

        Forced modes are relaxed from rest to (stiffness - Q) a = F / 2 + Q shift F, see
        `steady_points`. The third result (points, moving) is the net damping force per amplitude
        of the modes in limit cycles [rad^2/s^2]; NaN where forced modes do not become steady.
        """
        model, (force,) = self.flow.model, self.flow.force
        omega, forced = model.reduced.frequency[self.moving], force != 0.0
        room = np.maximum(self._range - np.abs(self.flow.shift * force), 0.0)
        a = np.zeros((len(moduli), model.modes), dtype=complex)
        a[:, forced] = 1e-6 * self._range[forced]
        a[:, self.moving] = moduli
        Omega = np.tile(self.flow.frequency[0], (len(moduli), 1))
        low, high = np.array([carrier_range(float(each)) for each in omega]).T
        for _ in range(60):
            flow = self._at(Omega)
            now = flow.balance(a)
            Q = now.friction[:, self.moving] / moduli
            square = np.nan_to_num(omega**2 - Q.real)
            Omega[:, self.moving] = np.clip(np.sqrt(np.maximum(square, 0.0)), low, high)
            balanced = flow.secant_response(now, a)
            modulus = 0.5 * (np.abs(a) + np.minimum(np.abs(balanced), self._range))
            relaxed = phasor(np.minimum(modulus, room), np.angle(balanced))
            off = np.abs(balanced - a)[:, forced] / self._range[forced]
            a[:, forced] = relaxed[:, forced]
        net = now.stiffness[:, self.moving].imag - Q.imag
        steady = np.all(off <= _STEADY, axis=1)
        _check_steady(steady, moduli)
        return a, Omega, np.where(steady[:, np.newaxis], net, np.nan)

    def _solved(self, a: Complexes, Omega: Floats) -> tuple[Complexes, Floats] | None:
        """Return a solution nearby, amplitudes and frequencies (modes,); None if there is none."""
        from scipy.optimize import root  # takes a while to import

        natural, most = self.flow.model.reduced.frequency, self._range
        solved = self.moving.tolist() + np.flatnonzero(self.flow.force[0]).tolist()
        cycles = self.moving.size

        def unpacked(z: Floats) -> tuple[Complexes, Floats]:
            pairs, now, frequency = z.reshape(-1, 2), a * 0.0, Omega.copy()
            now[solved] = most[solved] * (pairs[:, 0] + 1j * pairs[:, 1])
            now[self.moving] = most[self.moving] * pairs[:cycles, 0]
            frequency[self.moving] = natural[self.moving] * pairs[:cycles, 1]
            return now, frequency

        def residual(z: Floats) -> Floats:
            if not np.isfinite(z).all():  # after a point outside the table
                return np.full(z.size, np.nan)
            now, frequency = unpacked(z)
            found = self._at(frequency[np.newaxis]).balance(now[np.newaxis])
            force = ((found.mass * found.rate)[0] / (natural**2 * most))[solved]
            return np.stack((force.real, force.imag), axis=-1).ravel()

        start = np.stack(((a / most).real, (a / most).imag), axis=-1)
        start[self.moving, 1] = (Omega / natural)[self.moving]
        z = root(residual, start[solved].ravel(), options={"xtol": 1e-13}).x
        now, frequency = unpacked(z)
        if not np.abs(residual(z)).max() <= 1e-9 or np.any(now[self.moving].real <= 0.0):
            return None
        return now, frequency

    def _growth(self, a: Complexes, Omega: Floats) -> float:
        """Return the growth of small deviations but for a phase shift, which is neutral."""
        _, jacobian = self._at(Omega[np.newaxis]).rate_and_jacobian(a[np.newaxis])
        kept = np.delete(np.arange(2 * a.size), 2 * self.moving + 1)
        return float(np.linalg.eigvals(jacobian[0][np.ix_(kept, kept)]).real.max())

    def _at(self, Omega: Floats) -> ForcedFlow:
        force = np.tile(self.flow.force, (len(Omega), 1))
        return self.flow.with_inputs(inputs_of(force, Omega))

    @property
    def _range(self) -> Floats:
        return INSIDE * self.flow.model.table.amplitude_range
