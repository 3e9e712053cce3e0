"""Higher-order harmonics of the contact motion to which modes respond as well.

All modes respond to the contacts' harmonics up to `RESPONSE_ORDER`, and beyond it to those that
come close to a mode. Which of these move the contacts, and by how much they change S_j, is found
at a few amplitudes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.error_norm import ErrorNorm
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.march import ContactForces
from slipmode.rom.errors import UnsettledError
from slipmode.rom.reduction.combination import Order, harmonic_orders

# Of the largest amplitudes. The change of S_j may be largest where one mode is weak: up to
# (1, 0.5) a ninth of it was found (tests/rom/table/test_stated_error.py).
_PROBES = np.array(
    [[1.0, 1.0], [1.0, 0.5], [0.5, 1.0], [1.0, 0.25], [0.25, 1.0]]
    + [[share, share] for share in (0.5, 0.25, 0.125)]
)
LINES = 32  # phase lines that distinguish harmonics up to the 15th


def higher_order_harmonics(
    problem: ContactProblem,
    grid: Discretisation,
    amplitude_range: Floats,
    smallest: float,
    highest: int = 15,
) -> dict[Order, float]:
    """Return further harmonics whose response moves the contacts, and by how much.

    The highest response comes first. Rigid contacts hardly move by it: none.

    Parameters
    ----------
    problem : ContactProblem
    grid : Discretisation
        Harmonics that its phase lines cannot distinguish are left out.
    amplitude_range : (modes,) ndarray
        Largest amplitudes [kg^1/2 m].
    smallest : float
        Smallest motion that counts, relative to the motion without friction.
    highest : int
        Largest |n| + |m|.

    Raises
    ------
    UnsettledError
        If the contact motion converges at none of the amplitudes that are tried.
    """
    reduced, known = problem.reduced, problem.orders
    if reduced.contacts is None:
        return {}
    every = harmonic_orders(highest, amplitude_range.size, reduced.even)
    candidates = [order for order in every if order not in known]
    wide = replace(problem, orders=(*known, *candidates), requested=0)
    reaction = wide.forces.reaction
    known_alone = reaction.copy()
    known_alone[len(known) :] = 0.0
    coupling = wide.forces.coupling
    wide = replace(wide, given_forces=ContactForces(coupling, known_alone))
    amplitudes = _probes(amplitude_range)
    terms = wide.on(grid, smallest, 0.1 * amplitude_range).solve(amplitudes)
    if not terms.is_periodic.any():
        raise UnsettledError("contacts: the motion converges at none of the largest amplitudes")
    response = np.abs(np.einsum("qcd,pqd->pqc", reaction, terms.P)).max(axis=-1)[:, len(known) :]
    frictionless = np.abs(amplitudes @ coupling).max(axis=1, keepdims=True)
    share = (response / frictionless)[terms.is_periodic].max(axis=0, initial=0.0)
    ranked = np.argsort(-share, kind="stable")
    return {candidates[k]: float(share[k]) for k in ranked if share[k] > smallest}


def change_by_harmonics(
    problem: ContactProblem,
    higher: Iterable[Order],
    grid: Discretisation,
    amplitude_range: Floats,
    march_tolerance: float,
) -> float:
    """Return the change of S_j by the response of the modes to higher-order harmonics.

    It is the largest at the amplitudes where the motion converges with and without them, in terms
    of `ErrorNorm`.

    Raises
    ------
    UnsettledError
        If it converges at none of the amplitudes that are tried.
    """
    amplitudes = _probes(amplitude_range)
    wide = replace(problem, orders=(*problem.orders, *higher), requested=0)
    without, terms = (
        each.on(grid, march_tolerance, 0.1 * amplitude_range).solve(amplitudes)
        for each in (problem, wide)
    )
    settled = without.is_periodic & terms.is_periodic
    if not settled.any():
        raise UnsettledError("contacts: the motion converges at none of the largest amplitudes")
    norm = ErrorNorm.of(problem.reduced, amplitude_range).known(terms.S[settled])
    change = np.abs(terms.S - without.S) / norm.scale(amplitudes, terms.S)
    return float(change[settled].max())


def _probes(amplitude_range: Floats) -> Floats:
    """Return the amplitudes (points, modes) that are tried: of one mode the largest alone."""
    modes = amplitude_range.size
    return np.asarray(_PROBES[: len(_PROBES) if modes == 2 else 1, :modes] * amplitude_range)
