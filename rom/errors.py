"""The one exception that users of slipmode are meant to see."""


class SlipmodeError(ValueError):
    """Input or a state that slipmode refuses.

    The message is one line that names the key, variable or file at fault and says what is
    allowed or what to do next. The command line prints it as it is.
    """
