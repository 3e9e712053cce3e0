"""The contact problem as the core reads it."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.marched_modes import MarchedModes
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced

_ELASTIC = 2  # sm_law


def contact_problem(
    reduced: Reduced, law: Friction, orders: Sequence[Order] = ()
) -> kernel.Contact:
    """The contact problem along a trajectory; it keeps the arrays alive.

    The modes respond to the harmonics `orders` with what comes along with the slow trajectory.
    """
    return _problem(reduced, law, reduced.coupling, reduced.stiffness, _response(orders))


def torus_problem(
    reduced: Reduced,
    law: Friction,
    coupling: Complexes,
    orders: Sequence[Order],
    reaction: Complexes,
    marched: MarchedModes | None = None,
    held: Complexes | None = None,
    start: Complexes | None = None,
    periodic: Complexes | None = None,
    asked: int = 0,
) -> kernel.Contact:
    """The contact problem on the torus; it keeps the arrays alive.

    With these `marched` modes, which move by `periodic` harmonics, and `reaction` (orders, N_c,
    N_c) as the force of all others on the contacts by the harmonics `orders`, of which the first
    are `asked` for; see `torus_harmonics`.
    """
    response, stiffness = _response(orders), reduced.stiffness
    response.asked = asked
    _give(response, dynamic_stiffness=reaction, held=held, start=start)
    if marched is not None:
        stiffness = -marched.flexibility(reduced)
        response.marched = len(marched.drawn)
        _give(response, drawn=marched.drawn, advance=marched.advance, periodic=periodic)
    return _problem(reduced, law, coupling, stiffness, response)


def _response(orders: Sequence[Order]) -> kernel.ModalResponse:
    numbers = np.ascontiguousarray(orders, dtype=np.int32)
    response = kernel.ModalResponse(orders_count=len(orders), orders=numbers.ctypes.data)
    response.owned = (numbers,)
    return response


def _give(response: kernel.ModalResponse, **arrays: Complexes | Floats | None) -> None:
    """Set pointers to these, which it keeps alive; None: there is no such array."""
    for name, array in arrays.items():
        if array is not None:
            own = np.ascontiguousarray(array)
            setattr(response, name, own.ctypes.data)
            response.owned += (own,)


def _problem(
    reduced: Reduced,
    law: Friction,
    coupling: Complexes,
    stiffness: Floats,
    response: kernel.ModalResponse,
) -> kernel.Contact:
    coupling = np.ascontiguousarray(coupling)
    stiffness, damping, mass = (
        kernel.contiguous(matrix) for matrix in (stiffness, reduced.damping, reduced.mass)
    )
    problem = kernel.Contact(
        contacts=reduced.n_contacts,
        modes=len(reduced.modes),
        coupling=coupling.ctypes.data,
        stiffness=stiffness.ctypes.data,
    )
    problem.owned = (coupling, stiffness, damping, mass, response)
    if reduced.formulation == "consistent":
        problem.response = ctypes.addressof(response)
    if isinstance(law, Elastic):
        elastic = law.elements(reduced.n_contacts).kernel()
        problem.law = _ELASTIC
        problem.elastic = ctypes.addressof(elastic)
        problem.owned += (elastic,)
        return problem
    limit = limits(law, reduced.n_contacts)
    problem.law, problem.alpha = law.code, law.alpha
    problem.limit = limit.ctypes.data
    problem.damping = damping.ctypes.data
    if reduced.formulation == "consistent":
        problem.mass = mass.ctypes.data
    problem.owned += (limit,)
    return problem
