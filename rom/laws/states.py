"""States of elastic contacts at instants of a motion, and the energy in their springs.

A frictional contact is open if its normal force would be negative, N0 + k_n (x_n - gap) <= 0, and
slips if its tangential force reaches the limit, |T0 + f_t| >= mu N. Parallel Jenkins elements, as
in the Iwan law, slip if all of them do (macro-slip).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import SLIDERS, Elements
from slipmode.rom.short_repr import frozen

STUCK, SLIPPING, OPEN = 0, 1, 2
STATES = ("stuck", "slipping", "open")

_AT_LIMIT = 1.0 - 1e-9  # force at the friction limit but for rounding, relative to it


@frozen
class ContactStates:
    """State of each contact (element), which may have several contact DOFs; all (n, elements)."""

    state: NDArray[np.int8]  # STUCK, SLIPPING or OPEN
    normal_force: Floats  # N with the preload [N]; NaN if the law has none
    gap: Floats  # clearance, 0 if the contact touches [m]; NaN if the law has none

    def shares(self) -> Floats:
        """Return the share of the samples in each of STATES, (elements, 3)."""
        return np.stack([np.mean(self.state == k, axis=0) for k in range(len(STATES))], axis=-1)


def contact_states(
    elements: Elements, displacement: Floats, force: Floats, scale: Floats | float = 1.0
) -> ContactStates:
    """Return the states at instants of a motion, x_c and f (n, N_c) [m], [N].

    Along a normal f is N - N0, tangentially T - T0, as in `Motion` and `FullMotion`. `scale`, (n,)
    or a number, is a factor on limits and preloads.
    """
    shape = (len(displacement), len(elements.element))
    state = np.zeros(shape, dtype=np.int8)
    normal_force, gap = np.full(shape, np.nan), np.full(shape, np.nan)
    for k, element in enumerate(elements.element):
        if element["law"] == SLIDERS:
            column = element["column"][0]
            held = scale * elements.limit[column]
            state[:, k] = np.where(np.abs(force[:, column]) >= held * _AT_LIMIT, SLIPPING, STUCK)
            continue
        *tangential, normal = element["column"][: element["tangents"] + 1].tolist()
        preload, stiffness = scale * element["preload"], element["normal_stiffness"]
        pressed = preload + stiffness * (displacement[:, normal] - element["gap"])
        N = np.maximum(pressed, 0.0)
        held = element["friction"] * N
        at_rest = np.multiply.outer(scale, element["tangential_preload"][: len(tangential)])
        slips = np.linalg.norm(at_rest + force[:, tangential], axis=1) >= held * _AT_LIMIT
        state[:, k] = np.where(pressed <= 0.0, OPEN, np.where(slips, SLIPPING, STUCK))
        normal_force[:, k], gap[:, k] = N, np.maximum(-pressed, 0.0) / stiffness
    return ContactStates(state, normal_force, gap)


def stored_energy(elements: Elements, displacement: Floats, force: Floats) -> Floats:
    """Return the energy in the springs of contacts relative to rest, (n,) [J].

    NaN if there are several sliders in parallel, whose force does not determine it.
    """
    stored = np.zeros(len(displacement))
    for element in elements.element:
        if element["law"] == SLIDERS:
            stiffness = elements.slider[element["first_slider"], 1]
            alone = element["sliders"] == 1
            f = force[:, element["column"][0]]
            stored += 0.5 * f**2 / stiffness if alone else np.nan
            continue
        *tangential, normal = element["column"][: element["tangents"] + 1].tolist()
        at_rest = element["tangential_preload"][: len(tangential)]
        stored += 0.5 * np.sum(force[:, tangential] ** 2, axis=1) / element["tangential_stiffness"]
        stretch = force[:, tangential] / element["tangential_stiffness"]
        stored += (stretch - displacement[:, tangential]) @ at_rest
        x, preload = displacement[:, normal], element["preload"]
        pressed = preload + element["normal_stiffness"] * (x - element["gap"])
        squares = np.maximum(pressed, 0.0) ** 2 - preload**2
        stored += 0.5 * squares / element["normal_stiffness"] - preload * x
    return stored
