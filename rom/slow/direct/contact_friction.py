"""Friction from the contact problem itself, at any forcing frequency.

A friction table belongs to its reference frequencies, and leaves the response of the modes to
combination resonances to the slow flow. Here the contact problem is solved at each forcing
frequency, with the response of all modes to all harmonics, and with the forces on the contacts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.contact.problem import TorusProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import harmonic_orders, resonant_modes
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.table.model import Model

# March tolerance: finite differences of the force need far smaller changes than the answer.
_MARCH_TOLERANCE = 1e-7


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

    @classmethod
    def of(
        cls, flow: ForcedFlow, amplitude: Complexes, at: NDArray[np.intp] | None = None
    ) -> Self:
        """Return all points of a flow, or those with the numbers `at`."""
        some = slice(None) if at is None else at
        scale = flow.inputs["limit_scale"][some, np.newaxis]
        force, a = flow.force[some] / scale, amplitude[some] / scale
        # a mode at rest without force has no frequency: the table's serves as well
        rests = (force == 0.0) & (a == 0.0)
        frequency = np.where(rests, flow.model.reduced.carrier, flow.frequency[some])
        return cls(frequency, force, a, scale)


@dataclass(eq=False)
class ContactFriction:
    """The force of the contacts on the modes, by contact problems at the forcing frequencies.

    Each problem begins with the harmonics of the last one.
    """

    torus: TorusProblem
    applied: AppliedForces | None  # None: the forces act as in the table
    _harmonics: Complexes | None = None

    @classmethod
    def of(cls, model: Model, applied: AppliedForces | None, *, finer: bool = False) -> Self:
        """Return the friction of a model, in the time steps of its table, or in finer ones."""
        torus = model.finer_contact_problem(
            smallest_scale(model.reduced, model.table.amplitude_range)
        )
        problem, grid = replace(torus.problem, combinations=()), torus.grid
        if finer:
            return cls(problem.on(grid, torus.march.tolerance, torus.smallest_amplitude), applied)
        grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
        return cls(problem.on(grid, _MARCH_TOLERANCE, torus.smallest_amplitude), applied)

    def __call__(self, points: ContactPoints) -> Complexes:
        """Return the force on the modes, (points, modes) [N kg^-1/2].

        NaN where the contact motion does not converge.
        """
        found = np.full(points.amplitude.shape, np.nan, dtype=complex)
        size = np.abs(points.amplitude)
        for k, a in enumerate(points.amplitude):
            try:
                there = self._at(points.frequency[k], points.force[k], a)
                terms = there.on_more_lines(there.solve(size[k : k + 1], self._harmonics))
            except SlipmodeError:
                continue
            if terms.is_periodic[0]:
                self._harmonics = terms.P
                found[k] = terms.S[0] * np.exp(1j * np.angle(a))
        return np.asarray(points.scale * found)

    def _at(self, frequency: Floats, force: Complexes, amplitude: Complexes) -> TorusProblem:
        """Return the contact problem at one point."""
        torus = self.torus
        problem = torus.problem.at_carriers(frequency)
        if self.applied is not None:
            bare = replace(problem.reduced, force_patterns=None)
            per_amplitude = np.divide(
                0.5 * force, amplitude, out=np.zeros_like(amplitude), where=amplitude != 0.0
            )
            direct = replace(self.applied, reduced=bare).past_mode * per_amplitude[:, np.newaxis]
            reaction = replace(problem, reduced=bare).forces.reaction
            forces = ContactForces(bare.coupling - direct, reaction)
            problem = replace(problem, reduced=bare, given_forces=forces)
        return problem.on(torus.grid, torus.march.tolerance, torus.smallest_amplitude)


def changed_reaction(model: Model, frequency: Floats) -> Floats:
    """Return how much the reaction of the modes differs from the table's, (points,) [-].

    At forcing frequencies (points, modes), the largest of all harmonics, relative to the contacts'
    own stiffness or flexibility. Harmonics of friction fall with the square of their order.
    """
    reduced = model.reduced
    modes = len(reduced.modes)
    orders = tuple(harmonic_orders(RESPONSE_ORDER, modes, reduced.even))
    numbers = np.array(orders)[:, :modes]
    there = reduced.reaction(frequency @ numbers.T, resonant_modes(modes, orders, ()))
    change = np.abs(there - reaction_stiffness(reduced, orders, model.combinations))
    # of rigid contacts a force per displacement, of elastic ones a displacement per force
    contacts = reduced.contacts
    own = (
        np.diag(reduced.stiffness)
        if contacts is None
        else 1.0 / np.maximum(contacts.reference, np.finfo(float).tiny)
    )
    share = (change / np.sqrt(np.outer(own, own))).max(axis=(-2, -1))
    decay = np.maximum(np.abs(numbers).sum(axis=1), 1) ** 2
    return np.asarray((share / decay).max(axis=1))
