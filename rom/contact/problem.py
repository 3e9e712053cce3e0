"""The contact problem of steady motion, Eqs. (13) and (14): problem, grid, solution.

    problem = ContactProblem.of(reduced, law)
    terms = problem.on(Discretisation(steps=64, lines=16), 1e-5).solve(amplitudes)
    terms.S   # friction terms of the amplitude equations, Eq. (20)

The core (rom/kernel/torus) marches the contacts along the torus of the two phases until their
motion is periodic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.contact.time_budget import WorkLimit, contact_size
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces, TorusMarch
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import (
    CARRIERS,
    CombinationResonance,
    Order,
    harmonic_orders,
)
from slipmode.rom.reduction.force_response import steady_coupling, steady_reaction
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reaction import reaction_stiffness
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen


@frozen
class ContactProblem:
    """Contacts that the modes move at their carriers, whatever the amplitudes.

    Attributes
    ----------
    reduced : Reduced
    law : Friction
    orders : tuple of (n, m)
        Harmonics P_nm of the contact motion that are computed and to which the other modes
        respond. The carriers of the retained modes come first.
    combinations : tuple of CombinationResonance
        Harmonics that drive the slow flow of a mode, which does not respond to them here.
    requested : int
        Number of the first orders that must converge to the march tolerance. The others of
        sliders may be less exact, as far as modes do not respond to them. 0: all.
    given_forces : ContactForces, optional
        Forces on the contacts. Default: of modes in a steady state under their forces.
    work : WorkLimit, optional
        Count and limit of the work. Default: no limit.
    """

    reduced: Reduced
    law: Friction
    orders: tuple[Order, ...] = CARRIERS
    combinations: tuple[CombinationResonance, ...] = ()
    requested: int = 0
    given_forces: ContactForces | None = None
    work: WorkLimit | None = None

    @classmethod
    def of(
        cls,
        reduced: Reduced,
        law: Friction,
        combinations: Sequence[CombinationResonance] = (),
        highest: int = 1,
        higher_orders: Sequence[Order] = (),
    ) -> Self:
        """Return the problem with all harmonics to which the modes respond.

        Parameters
        ----------
        highest : int
            Largest |n| + |m| of the requested harmonics.
        higher_orders : sequence of (n, m)
            Further harmonics to which the modes respond, see `higher_order_harmonics`.
        """
        if reduced.shares_tone:
            reduced.refuse_shared_tone("reduced: must be of one or two modes with a carrier each")
        orders = [*higher_orders]
        if reduced.formulation == "consistent":
            orders[:0] = harmonic_orders(RESPONSE_ORDER, len(reduced.modes), reduced.even)
        return cls(reduced, law, tuple(orders), tuple(combinations)).requesting(highest)

    def requesting(self, highest: int) -> Self:
        """Return the problem with further requested harmonics.

        Parameters
        ----------
        highest : int
            Largest |n| + |m| of the harmonics that are requested besides combination resonances.
        """
        lowest = harmonic_orders(highest, len(self.reduced.modes), self.reduced.even)
        stored = [term.stored_order for term in self.combinations]
        requested = dict.fromkeys([*lowest, *stored])
        orders = tuple(dict.fromkeys([*requested, *self.orders]))
        return replace(self, orders=orders, requested=len(requested))

    def at_carriers(self, frequency: Floats) -> Self:
        """Return the problem with other carriers (modes,) [rad/s]."""
        return replace(self, reduced=self.reduced.at_carrier(frequency.tolist()))

    @cached_property
    def forces(self) -> ContactForces:
        """Forces of the modes on the contacts, without friction."""
        if self.given_forces is not None:
            return self.given_forces
        reaction = reaction_stiffness(self.reduced, self.orders, self.combinations)
        if self.reduced.force_patterns is not None:
            reaction = reaction.copy()
            for carrier, steady in zip(CARRIERS, steady_reaction(self.reduced), strict=False):
                if carrier in self.orders:
                    reaction[self.orders.index(carrier)] += steady
        return ContactForces(steady_coupling(self.reduced), reaction)

    def on(
        self,
        grid: Discretisation,
        march_tolerance: float = 1e-5,
        smallest_amplitude: ArrayLike = (0.0, 0.0),
    ) -> TorusProblem:
        """Return the discretised problem.

        Parameters
        ----------
        grid : Discretisation
        march_tolerance : float
            A march ends when the harmonics of successive periods agree to this fraction of the
            frictionless contact displacement at the point's amplitudes.
        smallest_amplitude : (modes,) array_like
            Amplitudes whose frictionless displacement is the scale instead, where it is larger
            [kg^1/2 m].
        """
        smallest = kernel.contiguous(smallest_amplitude)
        march = TorusMarch.of(self, grid, march_tolerance, smallest)
        return TorusProblem(self, grid, march_tolerance, smallest, march)


@frozen
class TorusProblem:
    """A contact problem on a grid of the torus; see `ContactProblem.on`."""

    problem: ContactProblem
    grid: Discretisation
    tolerance: float  # of the march
    smallest_amplitude: Floats
    march: TorusMarch

    def solve(self, amplitudes: ArrayLike, initial_guess: Complexes | None = None) -> ContactTerms:
        """Solve for the periodic motion of the contacts.

        Parameters
        ----------
        amplitudes : (points, modes) array_like
            |a_j| [kg^1/2 m], >= 0.
        initial_guess : (points, orders, N_c) complex ndarray, optional
            Harmonics of elastic contacts, and of rigid ones to which the modes respond strongly.
            Default: of elastic contacts, the harmonics at the previous point.

        Notes
        -----
        Marched at the carrier frequencies along t_B = t_B0 + (omega_B / omega_A) t_A with an
        L-stable second-order rule; second order in `steps`, spectral in `lines`.
        """
        points, march, work = kernel.contiguous(amplitudes), self.march, self.problem.work
        modes, contacts = march.contact.modes, march.contact.contacts
        if points.ndim != 2 or points.shape[1] != modes:
            raise SlipmodeError(f"amplitudes: must have shape (points, {modes})")
        if work is not None:
            work.check()
        count = len(points)
        P = np.empty((count, len(self.problem.orders), contacts), dtype=complex)
        guess = None if initial_guess is None else np.ascontiguousarray(initial_guess)
        if guess is not None and guess.shape != P.shape:
            raise SlipmodeError(f"initial_guess: must have shape {P.shape}, got {guess.shape}")
        mean_square, residual = np.empty((count, contacts)), np.empty(count)
        marched = np.empty(count, dtype=np.int32)
        at = kernel.TorusPoints(count, points, guess)
        motion = kernel.TorusMotion(P, mean_square, residual, marched)
        status = kernel.lib.sm_torus_harmonics(march.contact, march.discretisation, at, motion)
        kernel.check(status, "contact problem on the torus")
        if work is not None:
            size = contact_size(contacts, self.problem.reduced.contacts)
            work.add(float(marched.sum()) * march.discretisation.lines * size)
        P[:, ~march.distinguishable] = 0.0
        return ContactTerms(self.problem, points, P, mean_square, residual, marched)

    def on_more_lines(self, terms: ContactTerms) -> ContactTerms:
        """Return terms with more phase lines at the points where the motion is not periodic.

        Lines of rigid contacts drift against the grid. Where a contact slips on few of them, its
        harmonics keep changing by the error of the grid.
        """
        finer = self
        if self.problem.reduced.contacts is not None or len(self.problem.reduced.modes) == 1:
            return terms
        while finer.grid.lines < 8 * self.grid.lines:
            (moving,) = np.nonzero(terms.residual > self.tolerance)
            if not moving.size:
                break
            grid = replace(finer.grid, lines=2 * finer.grid.lines)
            finer = self.problem.on(grid, self.tolerance, self.smallest_amplitude)
            terms = terms.replaced(moving, finer.solve(terms.amplitudes[moving]))
        return terms
