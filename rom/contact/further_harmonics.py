"""Harmonics of higher order that modes respond to as well.

All modes respond to the contacts' harmonics up to `RESPONSE_ORDER`, and beyond it to those that
come near a mode; which of these move the contacts is found where the contacts move most.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.friction_terms import contact_orders
from slipmode.rom.contact.settled import UNSETTLED
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import reaction_stiffnesses, torus_harmonics
from slipmode.rom.errors import UnsettledError
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CombinationResonance, Order, harmonic_orders
from slipmode.rom.reduction.force_response import steady_coupling
from slipmode.rom.reduction.nonresonant import HIGHEST_HARMONIC
from slipmode.rom.reduction.reduction import Reduced

_HIGHEST = {1: HIGHEST_HARMONIC[1], 2: 15}  # |n| + |m|, by modes
_PROBES = np.array([[1.0, 1.0], [1.0, 0.5], [0.5, 1.0]])  # of the largest amplitudes
LINES = 32  # phase lines that tell all of them apart


def further_harmonics(
    reduced: Reduced,
    law: Friction,
    amplitude_range: Floats,
    grid: Discretisation,
    combinations: Sequence[CombinationResonance],
    smallest: float,
) -> dict[Order, float]:
    """Harmonics beyond `contact_orders` whose response moves the contacts, and by how much.

    The highest response comes first. Rigid contacts hardly give way to it: none.

    Parameters
    ----------
    amplitude_range : (modes,) ndarray
        Largest amplitudes [kg^1/2 m].
    grid : Discretisation
        Harmonics that its phase lines cannot tell apart are left out.
    smallest : float
        Motion that counts, relative to that without friction.

    Raises
    ------
    UnsettledError
        If the contact motion converges at none of the amplitudes that are tried.
    """
    if reduced.contacts is None:
        return {}
    modes = amplitude_range.size
    known = contact_orders(reduced, combinations)
    candidates = [
        (n, m) for n, m in harmonic_orders(_HIGHEST[modes], modes, reduced.even) if (n, m) not in known
    ]
    orders = [*known, *candidates]
    reaction = reaction_stiffnesses(reduced, tuple(orders), tuple(combinations))
    known_alone = reaction.copy()
    known_alone[len(known) :] = 0.0
    coupling = steady_coupling(reduced)
    amplitudes = (_PROBES[:, :modes] * amplitude_range)[: len(_PROBES) if modes == 2 else 1]
    solved = torus_harmonics(
        *(reduced, law, coupling, known_alone, amplitudes, grid, orders),
        tolerance=smallest,
        smallest_scale=0.1 * amplitude_range,
    )
    settled = solved.residual <= UNSETTLED
    if not settled.any():
        raise UnsettledError("contacts: their motion converges at none of the largest amplitudes")
    response = np.abs(np.einsum("qcd,pqd->pqc", reaction, solved.P)).max(axis=-1)[:, len(known) :]
    drawn = np.abs(amplitudes @ coupling).max(axis=1, keepdims=True)
    share = (response / drawn)[settled].max(axis=0, initial=0.0)
    ranked = np.argsort(-share, kind="stable")
    return {candidates[k]: float(share[k]) for k in ranked if share[k] > smallest}
