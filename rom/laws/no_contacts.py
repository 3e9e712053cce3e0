"""The law of a model that has no contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements, sliders_on


@dataclass(frozen=True)
class NoContacts:
    """Mark a model that has no contacts.

    The friction terms of such a model come from `rom.model_of_rates`.
    """

    def elements(self, contacts: int) -> Elements:
        """Return no elements; refuse a structure that has contacts."""
        if contacts > 0:
            raise SlipmodeError(
                f"law: NoContacts() is the law of rom.model_of_rates, but there are {contacts} "
                "contact DOFs; give a contact law"
            )
        return sliders_on(np.empty((0, 1)), np.empty((0, 1)))
