"""The contact problem on a grid of the torus as the core marches it, Eqs. (13), (14)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.contact.torus.grid import Discretisation, closed_lines
from slipmode.rom.contact.torus.marched_modes import MarchedModes
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen

if TYPE_CHECKING:
    from slipmode.rom.contact.problem import ContactProblem

_ELASTIC = 2  # sm_law
MOST_PERIODS = 400  # largest number of periods of mode A in a march


@frozen
class ContactForces:
    """Forces on the contacts besides friction.

    Attributes
    ----------
    coupling : (modes, N_c) complex ndarray
        -(force on the contacts) per amplitude a_j, at its carrier.
    reaction : (orders, N_c, N_c) complex ndarray
        Force on the contacts per harmonic P_nm: the response of the modes. Of size 0: the modes do
        not respond.
    constant : (orders, N_c) complex ndarray, optional
        Harmonics of a force that does not depend on the motion. Default: none.
    first_guess : (orders, N_c) complex ndarray, optional
        Harmonics P_nm whose reaction the iteration begins with. If it does not converge from
        there, it ends. Default: none.
    projection : (modes, N_c) complex ndarray, optional
        -(force on mode j) per harmonic P at its carrier. Default: the coupling of the modes, by
        reciprocity; in a travelling wave its conjugate.
    indirect : (modes,) complex ndarray, optional
        -(force on mode j) per a_j through other modes. Default: `Reduced.indirect_damping`.
    """

    coupling: Complexes
    reaction: Complexes
    constant: Complexes | None = None
    first_guess: Complexes | None = None
    projection: Complexes | None = None
    indirect: Complexes | None = None

    @property
    def prescribed(self) -> bool:
        """Whether no force depends on the contact motion."""
        return not self.reaction.size


@frozen
class TorusMarch:
    """A contact problem on a grid of the torus as the core reads it, whatever the amplitudes.

    Attributes
    ----------
    contact : sm_contact
    discretisation : sm_discretisation
    distinguishable : (orders,) ndarray of bool
        Orders that the phase lines of elastic contacts distinguish. The modes respond to these,
        the others are 0.
    """

    contact: kernel.Structure
    discretisation: kernel.Structure
    distinguishable: Flags

    @classmethod
    def of(
        cls,
        problem: ContactProblem,
        grid: Discretisation,
        tolerance: float,
        smallest_amplitude: Floats,
    ) -> Self:
        """Return the march of a problem, see `ContactProblem.on`."""
        reduced, forces = problem.reduced, problem.forces
        orders = np.array(problem.orders, dtype=np.int32)
        rates, lines = np.array(reduced.carrier, dtype=float), grid.lines
        distinguishable, marched = np.ones(len(orders), dtype=bool), 0
        reaction, stiffness = forces.reaction, reduced.stiffness
        arrays: dict[str, Any] = {"prescribed": forces.constant, "start": forces.first_guess}
        if reduced.contacts is not None and rates.size == 2:
            # Relative error of Omega_B / Omega_A on closed phase lines, over the march
            # tolerance: it changes S by about a third of that.
            lines, ratio = closed_lines(
                float(rates[1] / rates[0]),
                lines,
                3.0 * tolerance,
                odd=not reduced.even,
            )
            rates[1] = ratio * rates[0]
            distinguishable = 2 * np.abs(orders[:, 1]) < lines
        if forces.prescribed:
            reaction = np.zeros((len(orders), *stiffness.shape), dtype=complex)
        elif reduced.contacts is not None:
            modes, motion, reacting = _marched(reduced, grid.steps, problem.orders, tuple(rates))
            known = distinguishable[:, np.newaxis, np.newaxis]
            reaction = np.where(known, reaction - reacting, 0.0)
            stiffness, marched = -modes.flexibility(reduced), len(modes.drawn)
            arrays |= {"projection": modes.drawn, "advance": modes.advance}
            arrays["periodic"] = np.where(known, motion, 0.0)
        arrays["dynamic_stiffness"] = reaction
        response = kernel.ModalResponse(
            orders_count=len(orders),
            orders=orders,
            requested=problem.requested,
            marched=marched,
            **{name: np.ascontiguousarray(a) for name, a in arrays.items() if a is not None},
        )
        discretisation = kernel.Discretisation(
            rates=rates,
            steps=grid.steps,
            lines=lines,
            orders_count=len(orders),
            orders=orders,
            tolerance=tolerance,
            smallest_scale=smallest_amplitude,
            max_periods=MOST_PERIODS,
        )
        contact = _contact(reduced, problem.law, forces.coupling, stiffness, response)
        return cls(contact, discretisation, distinguishable)


@lru_cache(maxsize=8)
def _marched(
    reduced: Reduced, steps: int, orders: tuple[Order, ...], rates: tuple[float, ...]
) -> tuple[MarchedModes, Complexes, Complexes]:
    """Return marched modes, their periodic motion and response.

    A search for a steady state marches the same modes in every iteration.
    """
    modes = MarchedModes.of(reduced, steps)
    at = np.array(rates)
    return modes, modes.periodic(at, orders), modes.response(at, orders)


def contact_problem(
    reduced: Reduced, law: Friction, orders: Sequence[Order] = ()
) -> kernel.Structure:
    """Return the contact problem along a slow trajectory; it keeps its arrays alive.

    The modes respond to the harmonics `orders` with what comes along with the trajectory.
    """
    numbers = np.array(orders, dtype=np.int32)
    response = kernel.ModalResponse(orders_count=len(orders), orders=numbers)
    return _contact(reduced, law, reduced.coupling, reduced.stiffness, response)


def _contact(
    reduced: Reduced,
    law: Friction,
    coupling: Complexes,
    stiffness: Floats,
    response: kernel.Structure,
) -> kernel.Structure:
    contact = kernel.Contact(
        contacts=reduced.n_contacts,
        modes=len(reduced.modes),
        coupling=np.ascontiguousarray(coupling),
        stiffness=kernel.contiguous(stiffness),
    )
    if reduced.formulation == "consistent":
        contact.response = response
    if isinstance(law, Elastic):
        contact.law = _ELASTIC
        contact.elastic = law.elements(reduced.n_contacts).kernel()
        return contact
    contact.law, contact.alpha = law.code, law.alpha
    contact.limit = limits(law, reduced.n_contacts)
    contact.damping = kernel.contiguous(reduced.damping)
    if reduced.formulation == "consistent":
        contact.mass = kernel.contiguous(reduced.mass)
    return contact
