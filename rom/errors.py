"""The exceptions that users of slipmode are meant to see."""


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
