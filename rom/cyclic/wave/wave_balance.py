"""Amplitudes at which a wave is in balance: under a force, or on a limit cycle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.wave.wave_problem import Carrier, wave_contact_problem
from slipmode.rom.cyclic.wave.wave_resonances import naming_resonance
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.short_repr import frozen

_STEPS = (128, 256, 512, 1024, 2048, 4096)  # per period, until the amplitudes stay
_AMPLITUDES = 60  # tried for steady states
_MARCH = 1e-8  # distance from periodicity
_ROOT = 1e-10  # relative error of |a|
_FINER = 4  # steps of the grid on which a solution is put back into the equations, relative
_SLOPE = 1e-4  # relative change of |a| for the slope of the required force


@frozen
class Balance:
    """The forces on a wave, at one frequency.

    Attributes
    ----------
    carrier : Carrier
    problem : ContactProblem
    steps : int
        Per period.
    """

    carrier: Carrier
    problem: ContactProblem
    steps: int

    @classmethod
    def of(cls, carrier: Carrier, law: Elastic, steps: int) -> Self:
        """Return the forces on a wave with the contact law."""
        return cls(carrier, wave_contact_problem([carrier], law), steps)

    @cached_property
    def _torus(self) -> TorusProblem:
        return self.problem.on(Discretisation(self.steps, 1), _MARCH)

    def required(self, sizes: Floats) -> Complexes:
        """Return F per phase of a, 2 (D a - psi_r^H y_1), at |a| (points,)."""
        S = self._solved(sizes, None).S[:, 0]
        return np.asarray(2.0 * (self.carrier.stiffness * sizes - S))

    def harmonics(self, size: float, guess: Complexes | None = None) -> Complexes:
        """Return y_h of all harmonics at |a|, (orders, N_c); the iteration begins with a guess."""
        near = None if guess is None else guess[np.newaxis]
        return np.asarray(self._solved(np.array([size]), near).P[0])

    def _solved(self, sizes: Floats, near: Complexes | None) -> ContactTerms:
        terms = self._torus.solve(sizes[:, np.newaxis], near)
        with naming_resonance([self.carrier], self.problem):
            terms.check_periodic()
        return terms

    def sign_changes(self, part: Callable[[Complexes], Floats], sizes: Floats) -> list[float]:
        """Return |a| between `sizes` at which a part of the required force changes its sign."""
        import scipy.optimize  # takes long to import

        def at(size: float) -> float:
            return float(part(self.required(np.array([size])))[0])

        positive = part(self.required(sizes)) >= 0.0
        changes = positive[:-1] != positive[1:]
        return [
            float(scipy.optimize.brentq(at, low, high, xtol=_ROOT * low, rtol=_ROOT))
            for low, high in np.stack((sizes[:-1], sizes[1:]), axis=-1)[changes]
        ]

    def steady_sizes(self) -> list[float]:
        """Return all |a| at which the force is the required one, ascending [kg^1/2 m]."""
        force = abs(self.carrier.modal_force)
        stuck = 0.5 * force / abs(self.carrier.stiffness)
        sizes = np.geomspace(1e-3 * stuck, 2.0 * stuck, _AMPLITUDES)
        while np.abs(self.required(sizes[-1:])[0]) <= force:
            sizes = np.geomspace(sizes[0], 4.0 * sizes[-1], _AMPLITUDES)
        return self.sign_changes(lambda required: np.abs(required) - force, sizes)

    def steady_amplitude(self, size: float) -> complex:
        """Return a of the size |a|, with the phase at which the force is the required one."""
        (required,) = self.required(np.array([size]))
        turn = self.carrier.modal_force / required
        return complex(size * turn / abs(turn))

    def residual_error(self, a: complex) -> float:
        """Return the error of |a| by the residual of the equations on a finer grid [kg^1/2 m]."""
        size, finer = abs(a), replace(self, steps=_FINER * self.steps)
        required = finer.required(size * np.array([1.0, 1.0 + _SLOPE]))
        force = abs(self.carrier.modal_force)
        # a limit cycle neither gains nor loses energy
        here, beside = np.abs(required) - force if force else required.imag
        slope = (beside - here) / (_SLOPE * size)
        return abs(float(here / slope)) if slope else np.inf

    def displacement(self, a: complex) -> Complexes:
        """Return c of the free DOFs of sector 0, which move by 2 Re(c exp(i Omega t)), (n_s,)."""
        carrier, own, size = self.carrier, self.carrier.wave.own, abs(a)
        y = self.harmonics(size)[0]
        on_dofs = own.contacts.conj().T @ (y * (a / size)) + 0.5 * carrier.force
        others = own.response(on_dofs[:, np.newaxis], carrier.frequency, carrier.wave.mode)
        return np.asarray(carrier.mode.shape * a + others[:, 0])


@frozen
class Balanced:
    """A wave in balance: amplitude a [kg^1/2 m], and the error of |a|."""

    balance: Balance
    amplitude: complex
    error: float = np.inf


def on_steps_that_suffice(
    balanced: Callable[[int], list[Balanced]], tolerance: float
) -> list[Balanced]:
    """Return waves in balance for so many steps a period that the amplitudes no longer change.

    Each is put back into the equations on a finer grid, and its error includes the residual.

    Raises
    ------
    SlipmodeError
        If the error is above the tolerance at the largest number of steps.
    """
    coarse = balanced(_STEPS[0])
    for steps in _STEPS[1:]:
        found = balanced(steps)
        if len(found) == len(coarse):
            sizes = np.abs([each.amplitude for each in found])
            error = np.abs(sizes - np.abs([each.amplitude for each in coarse]))
            if np.all(error <= tolerance * sizes):
                # of a small change by chance the residual says more
                error += [each.balance.residual_error(each.amplitude) for each in found]
            if np.all(error <= tolerance * sizes):
                return [
                    replace(each, error=float(e)) for each, e in zip(found, error, strict=True)
                ]
        coarse = found
    raise SlipmodeError(
        f"tolerance: the relative error of the steady wave is above {tolerance:g} with "
        f"{_STEPS[-1]} steps per period; give a larger tolerance"
    )
