"""The contact problem on a grid of the torus as the core marches it, Eqs. (13), (14)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

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
MOST_PERIODS = 400  # of a march


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
    rates : (modes,) ndarray
        Of the phases [rad/s].
    steps, lines : int
    tolerance : float
    orders : (orders, 2) ndarray
    distinguishable : (orders,) ndarray of bool
        Orders that the phase lines of elastic contacts distinguish. The modes respond to these,
        the others are 0.
    """

    contact: kernel.Structure
    rates: Floats
    steps: int
    lines: int
    tolerance: float
    orders: NDArray[np.int32]
    distinguishable: Flags

    @classmethod
    def of(cls, problem: ContactProblem, grid: Discretisation, tolerance: float) -> Self:
        """Return the march of a problem, see `ContactProblem.on`."""
        reduced, orders, forces = problem.reduced, problem.orders, problem.forces
        rates, lines = kernel.contiguous(reduced.carrier).copy(), grid.lines
        distinguishable = np.ones(len(orders), dtype=bool)
        reaction, stiffness = forces.reaction, reduced.stiffness
        response = _modal_response(orders)
        response.requested = problem.requested
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
            distinguishable = 2 * np.abs(np.array(orders)[:, 1]) < lines
        if forces.prescribed:
            reaction = np.zeros((len(orders), *stiffness.shape), dtype=complex)
        elif reduced.contacts is not None:
            marched, motion, reacting = _marched(reduced, grid.steps, orders, tuple(rates))
            known = distinguishable[:, np.newaxis, np.newaxis]
            reaction = np.where(known, reaction - reacting, 0.0)
            periodic = np.where(known, motion, 0.0)
            stiffness = -marched.flexibility(reduced)
            response.marched = len(marched.drawn)
            _give(response, projection=marched.drawn, advance=marched.advance, periodic=periodic)
        _give(
            response,
            dynamic_stiffness=reaction,
            prescribed=forces.constant,
            start=forces.first_guess,
        )
        contact = _contact(reduced, problem.law, forces.coupling, stiffness, response)
        numbers = np.ascontiguousarray(orders, np.int32)
        return cls(contact, rates, grid.steps, lines, tolerance, numbers, distinguishable)


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
    response = _modal_response(orders)
    return _contact(reduced, law, reduced.coupling, reduced.stiffness, response)


def _modal_response(orders: Sequence[Order]) -> kernel.Structure:
    numbers = np.ascontiguousarray(orders, dtype=np.int32)
    return kernel.ModalResponse(orders_count=len(orders), orders=numbers)


def _give(response: kernel.Structure, **arrays: Complexes | Floats | None) -> None:
    """Set pointers to arrays; None: there is no such array."""
    for name, array in arrays.items():
        if array is not None:
            setattr(response, name, np.ascontiguousarray(array))


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
