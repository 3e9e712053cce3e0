"""How long something may take: seconds, or counted work, on which the load has no influence."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from threading import Lock

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements

# Time steps times `contact_size`: about 4e6 to 3e7 in a second of one processor. The largest table
# of a shipped scene takes 1.4e8 (`beating`).
MOST_WORK = 1.4e9
_RIGID = 0.2  # work of a rigid contact in a step, relative to an elastic one, about
_SLIDER = 0.125  # work of a slider in a step, relative to the work of a contact DOF, about


@dataclass(frozen=True)
class TimeBudget:
    """Seconds of the clock, from when this was made.

    Attributes
    ----------
    seconds : float
        inf: as many as it takes.
    """

    seconds: float
    _begun: float = field(default_factory=time.monotonic)

    @property
    def spent(self) -> bool:
        """Whether they are over."""
        return time.monotonic() - self._begun > self.seconds


@dataclass(eq=False)
class WorkLimit:
    """Count the work of a computation, and end it where it takes too much.

    Attributes
    ----------
    what : str
        What is computed.
    advice : str
        What would take less.
    seconds : float, optional
        Limit of the time instead of the work [s].
    """

    what: str
    advice: str
    seconds: float | None = None
    _done: float = 0.0
    _begun: float = field(default_factory=time.monotonic)
    _lock: Lock = field(default_factory=Lock)

    def add(self, work: float) -> None:
        """Count time steps times `contact_size`, and `check`."""
        with self._lock:
            self._done += work
        self.check()

    def check(self) -> None:
        """Refuse to continue if the limit is exceeded."""
        if self.seconds is None:
            if self._done <= MOST_WORK:
                return
            limit = f"{MOST_WORK:.2g} steps of contacts (one to five minutes)"
            longer = ", or a budget [s] if it may take longer"
        else:
            if time.monotonic() - self._begun <= self.seconds:
                return
            limit, longer = f"{self.seconds:g} s", ", or a larger budget"
        raise SlipmodeError(
            f"budget: the {self.what} takes more than {limit}. Give {self.advice}{longer}"
        )


def contact_size(contacts: int, elements: Elements | None) -> float:
    """Return the work of a step: the number of contact DOFs, and a part of the sliders."""
    return _RIGID * contacts if elements is None else contacts + _SLIDER * len(elements.slider)


def checked_budget(budget: float | None) -> float | None:
    """Return a budget [s] given by a user; refuse one that is not a finite number > 0."""
    if budget is not None and not (np.isfinite(budget) and budget > 0.0):
        raise SlipmodeError(f"budget: must be a finite number > 0 [s], got {budget}")
    return budget
