"""Tangential forces that friction can hold at rest, with the extreme friction limits.

Slips s of contacts that touch change the forces between them without any load. All s are
admissible for which each contact stays at or below its friction limit,

    |T_0 + T(s)| <= mu (N_0 + N(s)),   N_0 + N(s) >= 0,

and open contacts stay open. A limit mu N is linear in s, so that its extremes are linear programs.
Damping has a maximum between a small limit and a large one. All s between two admissible ones are
admissible.
"""

from __future__ import annotations

import numpy as np
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements

# Sides of the polygon within the circle of friction in two directions: mu is up to 2 % less.
_SIDES = 16
_TINY = np.finfo(float).tiny
_TOLERANCE = 1e-10  # of the linear programs, the least that HiGHS allows, relative to a preload
_SAME = 1e-6  # range of a limit that does not depend on the slips, relative to this preload
# Largest ratio of successive limits. With it the largest damping is up to 5 % too small, and
# 37 % without limits in between (wedge dampers of tests/rom/contact/test_wedge_damper.py).
_RATIO = 2.0
_RANGE = 64.0  # Largest ratio of all limits of a contact, which may be 0.


def admissible_slips(elements: Elements, moved: Floats) -> list[Floats]:
    """Return slips from the least to the largest friction limit of each contact in turn.

    Parameters
    ----------
    elements : Elements
        Contacts at rest, of which those with reference stiffness 0 are open.
    moved : (N_c, slips) ndarray
        Displacements [m] of contact DOFs per slip. Slips are of the tangential DOFs of contacts
        that touch, in their order, and given by their forces k_t s [N].

    Returns
    -------
    list of (slips,) ndarrays
        [N]. None for a contact whose limit does not depend on the slips.

    Raises
    ------
    SlipmodeError
        If a linear program has no solution.
    """
    size = max(float(elements.element["preload"].max()), _TINY)
    rows, slack, limits = _admissible(elements, moved)
    scale = np.maximum(np.abs(rows).max(axis=1), _TINY)
    rows, slack = rows / scale[:, np.newaxis], slack / scale / size
    slack = np.where(slack > 10.0 * _TOLERANCE, slack - 10.0 * _TOLERANCE, slack)
    found: list[Floats] = []
    for at_rest, per_slip in limits:
        ends = [
            scipy.optimize.linprog(
                sign * per_slip,
                rows,
                slack,
                bounds=(None, None),
                options={"primal_feasibility_tolerance": _TOLERANCE},
            )
            for sign in (1.0, -1.0)
        ]
        if any(end.status != 0 for end in ends):
            raise SlipmodeError(
                "bounds: no forces at rest were found within the friction limits; use history"
            )
        first, last = (size * np.asarray(end.x) for end in ends)
        least, largest = at_rest + per_slip @ first, at_rest + per_slip @ last
        if largest - least > _SAME * size:
            spread = largest / max(least, largest / _RANGE)
            count = 2 + int(np.log(spread) / np.log(_RATIO))
            between = np.geomspace(largest / spread, largest, count)
            between[0] = least
            parts = (between - least) / (largest - least)
            found += list(first + parts[:, np.newaxis] * (last - first))
    return found


def _admissible(
    elements: Elements, moved: Floats
) -> tuple[Floats, Floats, list[tuple[float, Floats]]]:
    """Return rows and slack of rows @ slips <= slack, and mu N at rest and per slip."""
    forces = elements.reference[:, np.newaxis] * moved
    rows, slack, limits, slip = [], [], [], 0
    for element in elements.element:
        *tangential, normal = element["column"][: element["tangents"] + 1].tolist()
        if elements.reference[normal] == 0.0:
            rows.append(moved[normal])
            slack.append(element["gap"])
            continue
        count = len(tangential)
        forces[tangential, slip + np.arange(count)] -= 1.0
        slip += count
        N_0, N, T = element["preload"], forces[normal], forces[tangential]
        rows.append(-N)
        slack.append(N_0)
        limits.append((element["friction"] * N_0, element["friction"] * N))
        sides = 2 if count == 1 else _SIDES
        within = element["friction"] * (1.0 if count == 1 else np.cos(np.pi / sides))
        for angle in 2.0 * np.pi / sides * np.arange(sides):
            along = np.array([np.cos(angle), np.sin(angle)])[:count]
            rows.append(along @ T - within * N)
            slack.append(within * N_0 - along @ element["tangential_preload"][:count])
    return np.array(rows), np.array(slack), limits
