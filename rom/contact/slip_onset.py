"""Where contacts begin to slip or open: lines in the amplitude plane at which friction has kinks.

A contact that sticks moves by 2 sum_j |L_j| |a_j| at most, whatever the phases: it yields where
that reaches what holds it. What moves it once others have yielded is not told here.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.laws.elements import SLIDERS, Elements
from slipmode.rom.laws.friction import Friction, RigidFriction, limits
from slipmode.rom.reduction.force_response import steady_coupling
from slipmode.rom.reduction.reduced import Reduced


def onset_lines(reduced: Reduced, law: Friction) -> Floats:
    """Normals n (lines, modes) of the lines n @ |a| = 1 at which a contact that sticks yields.

    Contacts that nothing holds, or that nothing moves, have none.
    """
    coupling = 2.0 * steady_coupling(reduced)
    if isinstance(law, RigidFriction):
        motion, holding = np.abs(coupling), limits(law, reduced.n_contacts)
    else:
        motion, holding = _elastic(coupling, law.elements(reduced.n_contacts))
    yields = (holding > 0.0) & (motion > 0.0).any(axis=0)
    return np.unique((motion[:, yields] / holding[yields]).T, axis=0)


def stick(reduced: Reduced, law: Friction, amplitudes: Floats) -> Flags:
    """Return at which amplitudes (points, modes) all contacts are certain to stick, (points,).

    Elastic contacts alone: what they do beside their reference springs is 0 there. Contacts that
    slide in two directions begin to on a curve that is not known.
    """
    if isinstance(law, RigidFriction):
        return np.zeros(len(amplitudes), dtype=bool)
    elements = law.elements(reduced.n_contacts).element
    if np.any((elements["law"] != SLIDERS) & (elements["tangents"] == 2)):
        return np.zeros(len(amplitudes), dtype=bool)
    return np.asarray((amplitudes @ onset_lines(reduced, law).T).max(axis=1, initial=0.0) < 1.0)


def _elastic(L: Complexes, elements: Elements) -> tuple[Floats, Floats]:
    """Force (modes, lines) per amplitude and the one that holds (lines,), or displacements.

    Friction on a disk, in two directions, begins on a curve that is left out.
    """
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
            motion += [np.abs(force + friction * pressing), np.abs(force - friction * pressing)]
            holding += 2 * [friction * element["preload"]]
    return np.array(motion).T, np.array(holding)
