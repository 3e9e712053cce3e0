"""Steady states and limit cycles of a wave, and their stability.

A wave is in balance where 2 (D(Omega) a - S(|a|, Omega)) = F. Under a force this determines a; in
a limit cycle F = 0 determines |a| and Omega, and the phase is arbitrary.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import scipy

from slipmode.rom import Discretisation, SlipmodeError
from slipmode.rom.common import Complexes, Floats, frozen
from slipmode.rom.contact import ContactTerms, TorusProblem, slip_onset
from slipmode.rom.cyclic.wave.stability.pair_stability import CriticalPair, critical_pair
from slipmode.rom.cyclic.wave.wave_problem import Carrier, WaveProblem, naming_resonance

# Time steps per period and highest harmonic to which the modes respond, in turn.
_LEVELS = (
    *((128, 15), (128, 31), (256, 31), (256, 63), (512, 63), (512, 127)),
    *((1024, 127), (2048, 127), (4096, 127)),
)
_AMPLITUDES = 60  # tried for steady states
# Tried for limit cycles, relative to the onset of slip: from micro-slip of joints with many
# sliders to contacts that hardly hold.
_FROM_ONSET = np.geomspace(1e-3, 1e4, 100)
_NEAR = np.array([0.5, 0.8, 0.97, 1.03, 1.25, 2.0])  # |a| at another frequency or level, relative
_CHANGE, _ITERATIONS = 1e-9, 30  # relative change of Omega^2 at convergence of a limit cycle
_MARCH = 1e-8  # distance from periodicity
_ROOT = 1e-10  # relative error of |a|


@frozen
class Balance:
    """The forces on a wave at one frequency.

    Attributes
    ----------
    problem : WaveProblem
        Of one wave.
    steps : int
        Per period.
    """

    problem: WaveProblem
    steps: int

    @property
    def carrier(self) -> Carrier:
        """The wave at this frequency."""
        return self.problem.carriers[0]

    @cached_property
    def _torus(self) -> TorusProblem:
        return self.problem.on(Discretisation(self.steps, 1), _MARCH)

    def terms(self, sizes: Floats, guess: Complexes | None = None) -> ContactTerms:
        """Return the contact terms at |a| (points,), from a guess (points, orders, N_c)."""
        terms = self._torus.solve(sizes[:, np.newaxis], guess)
        with naming_resonance(self.problem):
            terms.check_periodic()
        return terms

    def required(self, sizes: Floats) -> Complexes:
        """Return the force that holds a wave steady, F per phase of a, at |a| (points,)."""
        S = self.terms(sizes).S[:, 0]
        return np.asarray(2.0 * (self.carrier.mode.stiffness * sizes - S))

    def excess(self, sizes: Floats) -> Floats:
        """Return how much the required force exceeds the given one, at |a| (points,).

        A limit cycle neither gains nor loses energy: without a force it is the damping force.
        """
        required, force = self.required(sizes), abs(self.carrier.modal_force)
        return np.abs(required) - force if force else required.imag

    def solve(self, low: float, high: float) -> float:
        """Return |a| in a range at whose ends the excess has different signs, where it is 0."""

        def excess(size: float) -> float:
            return float(self.excess(np.array([size]))[0])

        return float(scipy.optimize.brentq(excess, low, high, xtol=_ROOT * low, rtol=_ROOT))


@frozen
class WaveState:
    """Hold a travelling wave in a steady state or limit cycle.

    The free DOFs of sector j move as 2 Re(c exp(i (Omega t + k 2 pi j / N))).

    Attributes
    ----------
    amplitude : complex
        Amplitude a of the mode [kg^1/2 m].
    error : float
        Estimated error of |a|: its change by half as many time steps, and by half as many
        harmonics [kg^1/2 m].
    balance : Balance
        Forces on the wave at its frequency.
    """

    amplitude: complex
    error: float
    balance: Balance

    @property
    def frequency(self) -> float:
        """Frequency Omega of the force or of the limit cycle [rad/s]."""
        return self.balance.carrier.frequency

    @cached_property
    def displacement(self) -> Complexes:
        """Harmonics c of the free DOFs of sector 0 at this frequency, (n_s,) [m]."""
        carrier, size = self.balance.carrier, abs(self.amplitude)
        own, mode = carrier.wave.own, carrier.wave.mode
        y = self.balance.terms(np.array([size])).P[0, 0] * (self.amplitude / size)
        forces = own.contacts.conj().T @ y + 0.5 * carrier.force
        others = own.response(forces[:, np.newaxis], carrier.frequency, mode)[:, 0]
        return np.asarray(carrier.mode.shape * self.amplitude + others)

    @cached_property
    def critical_pair(self) -> CriticalPair:
        """Pair of waves n and 2 k - n with the largest growth rate in the presence of this wave.

        All pairs of the family are computed at first access, in a slow flow of first order.

        Raises
        ------
        UnsettledError
            If no periodic contact motion is found.
        """
        return critical_pair(self.balance, abs(self.amplitude))

    @property
    def stable(self) -> bool:
        """Whether small waves of all nodal diameters of the family decay."""
        return self.critical_pair.growth < 0.0


def steady_waves(carrier: Carrier, tolerance: float) -> list[WaveState]:
    """Return all waves that a force holds steady, by ascending amplitude.

    Raises
    ------
    SlipmodeError
        If the error is above the tolerance with the largest number of time steps.
    """
    balance = _balance(carrier, *_LEVELS[0])
    stuck = 0.5 * abs(carrier.modal_force) / abs(carrier.stiffness)
    largest = 2.0 * stuck
    while balance.excess(np.array([largest]))[0] <= 0.0:
        largest *= 4.0
    sizes = np.geomspace(1e-3 * stuck, largest, _AMPLITUDES)
    return _states(balance, sizes, tolerance)


def wave_cycles(carrier: Carrier, tolerance: float) -> list[WaveState]:
    """Return all limit cycles of a wave, by ascending amplitude.

    Raises
    ------
    SlipmodeError
        If the wave is not self-excited, or no contact slips in it. If the error is above the
        tolerance at the largest number of steps.
    """
    wave, balance = carrier.wave, _balance(carrier, *_LEVELS[0])
    damping = carrier.stiffness.imag / carrier.frequency
    if damping >= 0.0:
        raise SlipmodeError(
            f"aerodynamics: mode {wave.mode} of nodal diameter {wave.nodal_diameter} is not "
            f"self-excited. Its damping is {damping:.4g} 1/s; rom.flutter_growth returns the "
            "self-excited nodal diameters"
        )
    onset, _ = slip_onset(balance.problem.reduced, wave.law, 0)
    if onset == 0.0:
        raise SlipmodeError(
            f"law: no contact slips in mode {wave.mode} of nodal diameter {wave.nodal_diameter}, "
            "so friction does not limit its amplitude"
        )
    return _states(balance, onset * _FROM_ONSET, tolerance)


def _states(balance: Balance, sizes: Floats, tolerance: float) -> list[WaveState]:
    """Return the waves in balance at |a| between `sizes`, ascending."""
    found = [_state(balance.carrier, each, tolerance) for each in _sign_changes(balance, sizes)]
    return [each for each in found if each is not None]


def _state(carrier: Carrier, near: Floats, tolerance: float) -> WaveState | None:
    """Return the wave with |a| in the range of `near`, with steps and harmonics that suffice.

    None if more of them show that there is none.
    """
    sizes = [np.nan, np.nan]
    for level in _LEVELS:
        solved = _solved(_balance(carrier, *level), near)
        if solved is None:
            return None
        balance, size = solved
        carrier, near = balance.carrier, size * _NEAR
        sizes.append(size)
        error = float(np.abs(np.diff(sizes[-3:])).sum())
        if error <= tolerance * size:
            force, (required,) = carrier.modal_force, balance.required(np.array([size]))
            turn = np.angle(force / required) if force else 0.0
            return WaveState(complex(size * np.exp(1j * turn)), error, balance)
    raise SlipmodeError(
        f"tolerance: the relative error of the steady wave is above {tolerance:g} with "
        f"{_LEVELS[-1][0]} steps per period; give a larger tolerance"
    )


def _balance(carrier: Carrier, steps: int, highest: int) -> Balance:
    return Balance(WaveProblem.of_waves([carrier], highest), steps)


def _solved(balance: Balance, near: Floats) -> tuple[Balance, float] | None:
    """Return the wave in balance with |a| in the range of `near`, at its frequency, and |a|."""
    for _ in range(_ITERATIONS):
        ranges = _sign_changes(balance, near)
        if not ranges.size:
            break
        distance = np.abs(np.log(ranges.prod(axis=1) / (near[0] * near[-1])))
        low, high = ranges[distance.argmin()]
        size = balance.solve(low, high)
        if balance.carrier.force.any():
            return balance, size
        square = balance.carrier.frequency**2
        # Re D = omega^2 - Omega^2 + ..., and Re(required) = 0 at the frequency of a limit cycle
        change = 0.5 * float(balance.required(np.array([size]))[0].real) / size
        if abs(change) <= _CHANGE * square:
            return balance, size
        problem = balance.problem.at_carriers(np.sqrt([square + change]))
        balance, near = replace(balance, problem=problem), size * _NEAR
    return None


def _sign_changes(balance: Balance, sizes: Floats) -> Floats:
    """Return ranges (n, 2) between neighbouring |a| in which the excess changes its sign."""
    positive = balance.excess(sizes) >= 0.0
    ranges = np.stack((sizes[:-1], sizes[1:]), axis=-1)
    return np.asarray(ranges[positive[1:] != positive[:-1]])
