"""Where contacts begin to slip or open: lines in the amplitude plane at which friction has kinks.

A contact that sticks moves by 2 sum_j |L_j| |a_j| at most, whatever the phases: it yields where
that reaches what holds it. What moves it once others have yielded is not told here.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.laws.elements import SLIDERS
from slipmode.rom.laws.friction import Friction, RigidFriction, limits
from slipmode.rom.reduction.force_response import steady_coupling
from slipmode.rom.reduction.reduced import Reduced


def onset_lines(reduced: Reduced, law: Friction) -> Floats:
    """Normals n (lines, modes) of the lines n @ |a| = 1 at which a contact that sticks yields.

    Contacts that nothing holds, or that nothing moves, have none.
    """
    motion, holding = _loads(reduced, law)
    yields = (holding > 0.0) & (motion > 0.0).any(axis=0)
    return np.unique((motion[:, yields] / holding[yields]).T, axis=0)


def stick(reduced: Reduced, law: Friction, amplitudes: Floats) -> Flags:
    """Return where all elastic contacts are certain to stick, (...,), at amplitudes (..., modes).

    What they do beside their reference springs is 0 there. Rigid contacts creep, or lose energy
    in their dampers, while they stick: False.
    """
    if isinstance(law, RigidFriction):
        return np.zeros(amplitudes.shape[:-1], dtype=bool)
    return largest_load(reduced, law, amplitudes) < 1.0


def largest_load(reduced: Reduced, law: Friction, amplitudes: Floats) -> Floats:
    """Return the largest load on a contact that sticks, relative to the load at which it yields.

    Below 1, no contact slips or opens at amplitudes up to these. Infinite where modes move a
    contact that nothing holds. Of friction in two directions it is an upper bound.

    Parameters
    ----------
    amplitudes : (..., modes) ndarray

    Returns
    -------
    (...,) ndarray
    """
    motion, holding = _loads(reduced, law, disks=True)
    load = np.abs(amplitudes) @ motion
    unheld = np.where(load > 0.0, np.inf, 0.0)
    share = np.divide(load, holding, out=unheld, where=holding > 0.0)
    return np.asarray(share.max(axis=-1, initial=0.0))


def _loads(reduced: Reduced, law: Friction, *, disks: bool = False) -> tuple[Floats, Floats]:
    """Return loads (modes, lines) per amplitude and what holds (lines,): forces, or displacements.

    Friction on a disk, in two directions, begins on a curve, of which there is only a bound. It is
    included if `disks`.
    """
    L = 2.0 * steady_coupling(reduced)
    if isinstance(law, RigidFriction):
        return np.abs(L), limits(law, reduced.n_contacts)
    elements = law.elements(reduced.n_contacts)
    motion, holding = [], []
    for element in elements.element:
        if element["law"] == SLIDERS:
            first = element["first_slider"]
            own = elements.slider[first : first + element["sliders"]]
            moved = np.abs(L[:, element["column"][0]])
            motion += [moved * stiffness for _, stiffness in own]
            holding += [limit for limit, _ in own]
            continue
        *tangential, normal = element["column"][: element["tangents"] + 1]
        pressing = element["normal_stiffness"] * L[:, normal]
        motion.append(np.abs(pressing))
        holding.append(element["preload"] or element["normal_stiffness"] * element["gap"])
        if element["tangents"] == 1:
            force, friction = (
                element["tangential_stiffness"] * L[:, tangential[0]],
                element["friction"],
            )
            motion += [np.abs(force - friction * pressing), np.abs(force + friction * pressing)]
            limit, pulled = friction * element["preload"], element["tangential_preload"][0]
            holding += [max(limit - pulled, 0.0), max(limit + pulled, 0.0)]
        elif disks:
            force = element["tangential_stiffness"] * np.linalg.norm(L[:, tangential], axis=1)
            motion.append(force + element["friction"] * np.abs(pressing))
            pulled = np.linalg.norm(element["tangential_preload"])
            holding.append(max(element["friction"] * element["preload"] - pulled, 0.0))
    return np.reshape(motion, (-1, len(L))).T, np.array(holding)


def slip_onset(reduced: Reduced, law: Friction, mode: int) -> tuple[float, float]:
    """Return amplitudes [kg^1/2 m] of a mode at which the first and the last contact slips.

    Contacts that the mode hardly moves are left out; 0 if it moves no contact with a limit.
    """
    yielding = onset_lines(reduced, law)[:, mode]
    first = yielding.max(initial=0.0)
    if first == 0.0:
        return 0.0, 0.0
    return float(1.0 / first), float(1.0 / yielding[yielding >= 0.1 * first].min())
