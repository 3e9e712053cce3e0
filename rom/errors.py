"""Exceptions, warnings and findings for users."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

Level = Literal["info", "warning", "error"]


class SlipmodeError(ValueError):
    """Report input or a state that slipmode refuses.

    The message is one line that names the key, variable or file, and states what is allowed or
    what to do. The command line prints this message without changes.
    """


class ValidityWarning(UserWarning):
    """Warn of a violated assumption of the method; the message states the measured indicator."""


class OutsideTableError(SlipmodeError):
    """Amplitudes outside the range of a friction table."""


class UnknownChannelError(SlipmodeError, KeyError):
    """A topic that is not in a recording."""

    __str__ = Exception.__str__  # without the quotes of KeyError


class UnsettledError(SlipmodeError):
    """A contact problem without a periodic motion that was found."""


def one_line_reason(error: object) -> str:
    """Return the message of an exception or a warning in one line."""
    return " ".join(str(error).split())


@contextmanager
def naming(what: object) -> Iterator[None]:
    """Let refusals within begin with the name of a file or a key."""
    try:
        yield
    except SlipmodeError as error:
        raise SlipmodeError(f"{what}: {error}") from error


@dataclass(frozen=True)
class Finding:
    """A modelling decision, or a violated assumption of the method, with its reason."""

    subject: str
    choice: str
    reason: str
    level: Level = "info"

    def line(self) -> str:
        """Return the finding as one line."""
        return f"{self.subject} {self.choice}: {self.reason}"


def warn(findings: Iterable[Finding], stacklevel: int = 3) -> None:
    """Issue findings above the level "info" as `ValidityWarning`."""
    for each in findings:
        if each.level != "info":
            warnings.warn(each.line(), ValidityWarning, stacklevel=stacklevel)
