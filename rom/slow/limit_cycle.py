"""Limit cycles of self-excited modes, in which friction dissipates the aerodynamic power.

The amplitude and the frequency of an unforced mode are both unknown:

    omega_j^2 - Omega_j^2 + i gamma_j Omega_j = Q_j(|a_A|, |a_B|).

The imaginary part determines the amplitude, the real part the frequency. A forced mode has its
amplitude equation as in a steady state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import TableError, off_carrier_findings
from slipmode.rom.slow.branches.solve_points import LOWEST_SQUARE, solve_points
from slipmode.rom.slow.slow_flow import ForcedFlow, inputs_of
from slipmode.rom.slow.steady_points import INSIDE
from slipmode.rom.table.model import Model
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import (
    check_carriers,
    forcing_findings,
    friction_findings,
    warn,
)


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
        the steady state that Newton's method finds from rest.

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
    model.reduced.refuse_shared_tone("model: must be of one mode, or of two tones")
    model.refuse_spin("a limit cycle")
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


@frozen
class _Cycling:
    """Some modes in limit cycles, with forced ones, and the others at rest.

    Unknowns of a mode in a limit cycle are its amplitude and the square of its frequency, of a
    forced mode the real and imaginary part of its amplitude. They are relative to the range of
    the friction table and to the square of the natural frequency.
    """

    flow: ForcedFlow  # at one point
    moving: NDArray[np.intp]  # numbers of the modes in limit cycles

    @property
    def _forced(self) -> NDArray[np.intp]:
        return np.flatnonzero(self.flow.force[0])

    def _unpacked(self, z: Floats) -> tuple[Complexes, Floats]:
        """Return amplitudes and frequencies (points, modes) of unknowns (points, k)."""
        model, cycles = self.flow.model, 2 * self.moving.size
        a = np.zeros((len(z), model.modes), dtype=complex)
        Omega: Floats = np.tile(self.flow.frequency[0], (len(z), 1))
        a[:, self.moving] = z[:, :cycles:2]
        relative = np.sqrt(np.maximum(z[:, 1:cycles:2], LOWEST_SQUARE))
        Omega[:, self.moving] = model.reduced.frequency[self.moving] * relative
        a[:, self._forced] = z[:, cycles::2] + 1j * z[:, cycles + 1 :: 2]
        return np.asarray(INSIDE * model.table.amplitude_range * a, dtype=complex), Omega

    def _residual(self, z: Floats) -> Floats:
        """Return the relative forces that are not balanced, (points, k).

        The imaginary part of a mode in a limit cycle, which determines its amplitude, is first.
        """
        a, Omega = self._unpacked(z)
        now = self._at(Omega).balance(a)
        model = self.flow.model
        left = now.mass * now.rate / model.reduced.frequency**2
        cycles = left[:, self.moving] / a[:, self.moving]
        forced = (left / model.table.amplitude_range)[:, self._forced]
        pairs = [part for each in cycles.T for part in (each.imag, each.real)]
        return np.array(pairs + [part for each in forced.T for part in (each.real, each.imag)]).T

    def solutions(self) -> Iterator[LimitCycle]:
        """Yield each limit cycle once."""
        cycles, forced = self.moving.size, self._forced.size
        n = 200 if cycles == 1 else 32  # amplitudes of each mode
        axes = np.meshgrid(*[np.arange(1, n + 1) / n] * cycles, indexing="ij")
        amplitudes = 2 * np.arange(cycles)
        start = np.zeros((n**cycles, 2 * (cycles + forced)))  # forced modes are at rest
        start[:, amplitudes] = np.stack(axes, axis=-1).reshape(-1, cycles)
        start[:, amplitudes + 1] = 1.0
        others = np.delete(np.arange(start.shape[1]), amplitudes)

        def at_amplitudes(z: Floats) -> Floats:
            every = start.copy()
            every[:, others] = z
            return self._residual(every)[:, others]

        start[:, others], steady = solve_points(at_amplitudes, start[:, others])
        if forced:
            _check_steady(steady, self._unpacked(start)[0][:, self.moving])
        z, found = solve_points(self._residual, start[steady])
        found &= (z[:, amplitudes] > 0.0).all(axis=1)
        known: list[Complexes] = []
        for a, Omega in zip(*self._unpacked(z[found]), strict=True):
            if all(np.abs(a - other).max() > 1e-6 * np.abs(a).max() for other in known):
                known.append(a)
                yield LimitCycle(a, Omega, self._growth(a, Omega))

    def _growth(self, a: Complexes, Omega: Floats) -> float:
        """Return the growth of small deviations but for a phase shift, which is neutral."""
        _, jacobian = self._at(Omega[np.newaxis]).rate_and_jacobian(a[np.newaxis])
        kept = np.delete(np.arange(2 * a.size), 2 * self.moving + 1)
        return float(np.linalg.eigvals(jacobian[0][np.ix_(kept, kept)]).real.max())

    def _at(self, Omega: Floats) -> ForcedFlow:
        force = np.tile(self.flow.force, (len(Omega), 1))
        return self.flow.with_inputs(inputs_of(force, Omega))


def _check_steady(steady: Flags, amplitudes: Complexes) -> None:
    """Refuse or report amplitudes (points, moving) at which forced modes are not steady."""
    if steady.all():
        return
    reason = "forced modes do not become steady inside the friction table"
    advice = "tabulate a larger range, or reduce the force"
    if not steady.any():
        raise SlipmodeError(f"force: {reason} at any amplitude; {advice}")
    apart = np.linalg.norm(amplitudes[~steady], axis=1)
    where = f"at amplitudes of {apart.min():.3g} to {apart.max():.3g} kg^1/2 m"
    warn([Finding("limit cycles", "may be missing", f"{reason} {where}; {advice}", "warning")])
