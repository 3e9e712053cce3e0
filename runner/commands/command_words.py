"""Messages of the library in the words of the command line: its options, and keys of scenes."""

from __future__ import annotations

import re
from collections.abc import Container

# Advice for Python, and what a user of the command line can do instead.
_ADVICE = (
    (r"tabulate with detuning=True", "compare with slipmode validate"),
    (r"put them at the forcing \(rom\.reduce\([^)]*\)\), or (compare with slipmode)", r"\1"),
    (r"tabulate (further|a larger range)", "give a larger model.amplitude"),
    (r"tabulate to (\S+) or more", r"give model.amplitude = \1 or more"),
    (r"\(rom\.full\)", '(model.table = "none")'),
    (r"\(rom\.Jenkins\)", '([[contacts]] with law = "jenkins")'),
    (r"\(rom\.preload, in scenes \[preload\]\)", "([preload])"),
    (r": up to where friction holds it says rom\.limit_cycles", ", and friction does not hold it"),
    (r"; rom\.limit_cycles .*", ""),
)
# Arguments of functions that commands call, and the keys of a scene that they come from.
_KEYS = {"amplitude": "model.amplitude"}


def command_words(message: str, options: Container[str] = ()) -> str:
    """Return a message that names command-line options and scene keys, not Python arguments.

    Parameters
    ----------
    message : str
        In one line; it may begin with the name of what is wrong, followed by a colon.
    options : container of str
        Names of the options of the command.
    """
    for advice, instead in _ADVICE:
        message = re.sub(advice, instead, message)
    name, colon, rest = message.partition(":")
    if colon and name in options:
        name = f"--{name}"
    elif colon and name == "frequency" and "span" in options:  # a scene's own have other names
        name = "--span"
    elif colon:
        name = _KEYS.get(name, name)
    return f"{name}{colon}{rest}"
