"""How long something may take."""

from __future__ import annotations

import time
from dataclasses import dataclass, field


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
