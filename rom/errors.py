"""The exceptions, warnings and findings that users of slipmode are meant to see."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Level = Literal["info", "warning", "error"]


class SlipmodeError(ValueError):
    """Input or a state that slipmode refuses.

    The message is one line that names the key, variable or file at fault and says what is
    allowed or what to do next. The command line prints it as it is.
    """


class ValidityWarning(UserWarning):
    """An assumption of the method is strained; the message holds the measured indicator."""


class OutsideTableError(SlipmodeError):
    """Amplitudes outside a friction table; a larger one helps."""


class UnknownChannelError(SlipmodeError, KeyError):
    """A topic that a recording does not have."""

    __str__ = Exception.__str__  # without the quotes of KeyError


class UnsettledError(SlipmodeError):
    """A contact problem whose search has found no periodic motion."""


@dataclass(frozen=True)
class Finding:
    """One thing that is, or is not, modelled; or an assumption that is strained."""

    subject: str
    choice: str
    reason: str
    level: Level = "info"


def warn(findings: Iterable[Finding], stacklevel: int = 3) -> None:
    """Issue findings above the level "info" as `ValidityWarning`."""
    for each in findings:
        if each.level != "info":
            words = f"{each.subject} {each.choice}: {each.reason}"
            warnings.warn(words, ValidityWarning, stacklevel=stacklevel)
