"""Contact motion as it is recorded: a channel for each contact, what it does told with it."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import SLIDERS, Elements
from slipmode.rom.laws.states import STATES, ContactStates, contact_states
from slipmode.runner.recording import channels


class ContactRecord:
    """Channels of the contacts of a structure, and rows for them.

    A contact is a contact DOF with rigid friction, an element of the law with elastic one.

    Parameters
    ----------
    elements : Elements or None
        None: rigid contacts.
    contacts : int
        Number of contact DOFs.
    prefix : str
        In front of the topics.
    """

    def __init__(self, elements: Elements | None, contacts: int, prefix: str = "") -> None:
        self._elements = elements
        if elements is None:
            self.channels = [channels.contact(i, prefix) for i in range(contacts)]
            return
        self.channels = [
            channels.elastic_contact(i, _tangents(element), prefix)
            for i, element in enumerate(elements.element)
        ]

    def rows(
        self,
        displacement: Floats,
        velocity: Floats,
        force: Floats,
        scale: Floats | float = 1.0,
    ) -> list[Floats]:
        """Samples of each channel, from motion (n, N_c), limits and preloads scaled."""
        if self._elements is None:
            every = (displacement, velocity, force)
            return [np.stack([part[:, i] for part in every], axis=1) for i in range(len(force.T))]
        states = contact_states(self._elements, displacement, force, scale)
        rows = []
        for k, element in enumerate(self._elements.element):
            tangents = _tangents(element)
            along = element["column"][: max(tangents, 1)].tolist()
            columns = [part[:, i] for i in along for part in (displacement, velocity, force)]
            if tangents:
                normal = element["column"][tangents]
                columns += [displacement[:, normal], velocity[:, normal]]
                columns += [states.normal_force[:, k], states.gap[:, k]]
            rows.append(np.stack([*columns, states.state[:, k]], axis=1))
        return rows

    def states(
        self, displacement: Floats, force: Floats, scale: Floats | float = 1.0
    ) -> ContactStates | None:
        """What the contacts do; None of rigid ones."""
        if self._elements is None:
            return None
        return contact_states(self._elements, displacement, force, scale)


def _tangents(element: np.void) -> int:
    """Tangential directions beside a normal; 0 of a law without one."""
    return 0 if element["law"] == SLIDERS else int(element["tangents"])


def said(shares: Floats) -> str:
    """In words, which part of the time contacts (elements, 3) spend in each state."""
    parts = []
    for name, part in zip(STATES, shares.T, strict=True):
        low, high = part.min(), part.max()
        range_ = f"{high:.0%}" if high - low < 5e-3 else f"{low:.0%} to {high:.0%}"
        parts.append(f"{name} {range_}")
    return f"contacts are {', '.join(parts)} of the time"
