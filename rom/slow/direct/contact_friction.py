"""Friction from the contact problem itself, at any forcing frequency.

A friction table belongs to its reference frequencies, and leaves the response of the modes to
combination resonances to the slow flow. Here the contact problem is solved at each forcing
frequency, with the response of all modes to all harmonics, and with the forces on the contacts.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import harmonic_orders, resonant_modes
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.interaction.internal_resonance import harmonic_decay, own_stiffness
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.direct.resonant_response import Resonances
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.table.model import Model

# March tolerance: finite differences of the force need far smaller changes than the answer.
_MARCH_TOLERANCE = 1e-9


def has_contact_problem(model: Model) -> bool:
    """Return whether a model has a contact problem at any frequency."""
    return model.reduced.formulation == "consistent" and model.reduced.n_contacts > 0


@frozen
class ContactPoints:
    """Amplitudes and inputs at points, each (points, modes), relative to the scale of limits."""

    frequency: Floats  # Omega_j [rad/s]
    force: Complexes  # modal F_j exp(i phase_j) [N kg^-1/2]
    amplitude: Complexes  # a_j [kg^1/2 m]
    scale: Floats  # (points, 1), factor on friction limits [-]
    response: Complexes  # (points, resonances), resonant responses [kg^1/2 m]

    @classmethod
    def of(cls, flow: ForcedFlow, amplitude: Complexes, response: Complexes | None = None) -> Self:
        """Return the points of a flow; by default without resonant responses."""
        scale = flow.inputs["limit_scale"][:, np.newaxis]
        force, a = flow.force / scale, amplitude / scale
        # a mode at rest without force has no frequency: the table's serves as well
        rests = (force == 0.0) & (a == 0.0)
        frequency = np.where(rests, flow.model.reduced.carrier, flow.frequency)
        none = np.zeros((len(a), 0), dtype=complex)
        q = none if response is None else response / scale
        return cls(frequency, force, a, scale, q)


class ContactMotion(NamedTuple):
    """What the contacts do at points; NaN where their motion does not converge."""

    force: Complexes  # (points, modes), on the modes [N kg^-1/2]
    carriers: Complexes  # (points, modes, N_c), harmonics of the contacts [m]
    rate: Complexes  # (points, resonances), of the resonant responses [kg^1/2 m/s]


@dataclass(eq=False)
class ContactFriction:
    """The force of the contacts on the modes, by contact problems at the forcing frequencies.

    Each problem begins with the harmonics of the last one. The responses of the modes to
    `resonances` are given; all others are part of the contact problem.
    """

    torus: TorusProblem
    finer_torus: TorusProblem  # in finer steps, which measure the error
    applied: AppliedForces | None  # None: the forces act as in the table
    resonances: Resonances
    _harmonics: Complexes | None = None

    @classmethod
    def of(cls, model: Model, applied: AppliedForces | None) -> Self:
        """Return the friction of a model, in the time steps of its table, without resonances."""
        finer = model.finer_contact_problem(
            smallest_scale(model.reduced, model.table.amplitude_range)
        )
        problem, smallest = finer.problem, finer.smallest_amplitude
        if not model.reduced.ratio:  # harmonics drive modes on one tone, and others in the problem
            problem = replace(problem, combinations=())
        grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
        torus = problem.on(grid, _MARCH_TOLERANCE, smallest)
        finer_torus = problem.on(finer.grid, finer.tolerance, smallest)
        return cls(torus, finer_torus, applied, Resonances.none(problem.orders))

    @property
    def without_guess(self) -> Self:
        """The friction whose next problem does not begin with the harmonics of the last one."""
        return replace(self, _harmonics=None)

    @property
    def finer(self) -> Self:
        """The friction in finer steps."""
        return replace(self.without_guess, torus=self.finer_torus)

    def with_resonances(self, frequency: Floats) -> Self:
        """Return the friction with given responses to strong resonances.

        `frequency` (points, modes) are the forcing frequencies at which there may be some.
        """
        problem = self.torus.problem
        if problem.combinations:
            return self.without_guess
        found = Resonances.along(problem.reduced, problem.orders, frequency)
        return replace(self.without_guess, resonances=found)

    def __call__(self, points: ContactPoints) -> Complexes:
        """Return the force on the modes, (points, modes) [N kg^-1/2]."""
        return self.motion(points).force

    def motion(self, points: ContactPoints) -> ContactMotion:
        """Return the motion of the contacts at points."""
        shape, contacts = points.amplitude.shape, self.torus.problem.reduced.n_contacts
        sizes = shape, (*shape, contacts), points.response.shape
        found = ContactMotion(*(np.full(size, np.nan, dtype=complex) for size in sizes))
        for k in range(shape[0]):
            with suppress(SlipmodeError):
                self._solve(points, k, found)
        return found

    def _solve(self, points: ContactPoints, k: int, found: ContactMotion) -> None:
        """Write the motion at one point, if it is periodic."""
        a, scale, torus = points.amplitude[k], points.scale[k, 0], self.torus
        problem, resonances = self._at(points.frequency[k], points.force[k], a), self.resonances
        turn = np.exp(1j * np.angle(a))
        # the contact problem has real amplitudes
        turned = np.prod(turn ** resonances.numbers[:, : a.size], axis=1)
        nu, D, B = resonances.matrices(problem.reduced)
        q = points.response[k] / turned
        if q.size:
            reaction = problem.forces.reaction - resonances.reaction(problem.reduced)
            given = replace(problem.forces, reaction=reaction, constant=resonances.force(B, q))
            problem = replace(problem, given_forces=given)
        there = problem.on(torus.grid, torus.tolerance, torus.smallest_amplitude)
        terms = there.on_more_lines(there.solve(np.abs(a)[np.newaxis], self._harmonics))
        if not terms.is_periodic[0]:
            return
        self._harmonics = terms.P
        carriers = terms.at_carriers(turn[np.newaxis])[0]
        beside = carriers - terms.P[0, : a.size] * turn[:, np.newaxis]
        locked = -np.einsum("jc,jc->j", problem.reduced.coupling, beside)
        found.force[k] = scale * (terms.S[0] * turn + locked)
        found.carriers[k] = scale * carriers
        driven = np.einsum("uc,uc->u", B, terms.P[0, resonances.order])
        found.rate[k] = -scale * turned * (D @ q + driven) / (2j * nu)

    def _at(self, frequency: Floats, force: Complexes, amplitude: Complexes) -> ContactProblem:
        """Return the contact problem at one point."""
        problem = self.torus.problem.at_carriers(frequency)
        if self.applied is not None:
            bare = replace(problem.reduced, force_patterns=None)
            per_amplitude = np.divide(
                0.5 * force, amplitude, out=np.zeros_like(amplitude), where=amplitude != 0.0
            )
            direct = replace(self.applied, reduced=bare).past_mode * per_amplitude[:, np.newaxis]
            reaction = replace(problem, reduced=bare).forces.reaction
            forces = ContactForces(bare.coupling - direct, reaction)
            problem = replace(problem, reduced=bare, given_forces=forces)
        return problem


class ContactSolutions(NamedTuple):
    """Contact problems and resonant responses that give the friction at steady states."""

    friction: ContactFriction
    response: Complexes  # (points, resonances), resonant responses [kg^1/2 m]


def changed_reaction(model: Model, frequency: Floats) -> Floats:
    """Return how much the reaction of the modes differs from the table's, (points,) [-].

    At forcing frequencies (points, modes), the largest of all harmonics, relative to the contacts'
    own stiffness or flexibility. Harmonics of friction fall with the square of their order.
    """
    reduced = model.reduced
    modes = len(reduced.modes)
    orders = tuple(harmonic_orders(RESPONSE_ORDER, modes, reduced.even))
    nu = frequency @ np.array(orders)[:, :modes].T
    there = reduced.reaction(nu, resonant_modes(modes, orders, ()))
    change = np.abs(there - reaction_stiffness(reduced, orders, model.combinations))
    own = own_stiffness(reduced)
    share = (change / np.sqrt(np.outer(own, own))).max(axis=(-2, -1))
    return np.asarray((share / harmonic_decay(orders)).max(axis=1))
