"""The forces on a wave in a steady state or limit cycle, F = 2 (D a - S)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import TorusProblem
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.wave.wave_problem import Carrier, WaveProblem
from slipmode.rom.cyclic.wave.wave_resonances import naming_resonance
from slipmode.rom.short_repr import frozen

_MARCH = 1e-8  # distance from periodicity
_ROOT = 1e-8  # relative error of |a|


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
        import scipy.optimize  # takes long to import

        def excess(size: float) -> float:
            return float(self.excess(np.array([size]))[0])

        return float(scipy.optimize.brentq(excess, low, high, xtol=_ROOT * low, rtol=_ROOT))

    def displacement(self, a: complex) -> Complexes:
        """Return c of the free DOFs of sector 0, which move by 2 Re(c exp(i Omega t)), (n_s,)."""
        carrier, size = self.carrier, abs(a)
        own, mode = carrier.wave.own, carrier.wave.mode
        y = self.terms(np.array([size])).P[0, 0] * (a / size)
        forces = own.contacts.conj().T @ y + 0.5 * carrier.force
        others = own.response(forces[:, np.newaxis], carrier.frequency, mode)[:, 0]
        return np.asarray(carrier.mode.shape * a + others)
