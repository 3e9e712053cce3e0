"""Messages of the library in the words of the command line: its options, and keys of scenes."""

from __future__ import annotations

import re
from collections.abc import Container

# Advice for Python, and the advice for a user of the command line.
_ADVICE = (
    (
        r"Tabulate at the forcing frequency, or with detuning=True",
        "Compare with slipmode validate",
    ),
    # the reference frequency of a scene is the mean frequency of its forcing
    (
        r"Call rom\.reduce with carrier = this frequency, or compare",
        "Keep the frequencies closer to the mean frequency of the forcing, or compare",
    ),
    (
        r"Call rom\.reduce with carrier = (\S+) rad/s",
        r"Give the forcing of the scene a frequency of \1 rad/s",
    ),
    (
        r"Use rom\.steady_state, or a model of one mode, or compare",
        "Use a scene that forces one mode only, or compare",
    ),
    (r" or rom\.steady_state\b", ""),
    (r"\brom\.steady_state, or time integration \(rom\.full\)", 'model.table = "none"'),
    (
        r"tabulate (further|a larger range)",
        "give a larger model.amplitude (or a model.file with a larger range)",
    ),
    (r"tabulate to (\S+) or more", r"give model.amplitude = \1 or more"),
    (r"\(rom\.full\)", '(model.table = "none")'),
    (r"\(rom\.Jenkins\)", '([[contacts]] with law = "jenkins")'),
    (r"\(rom\.preload, in scenes \[preload\]\)", "([preload])"),
    (r": up to where friction holds it says rom\.limit_cycles", ", and friction does not hold it"),
    (r"; rom\.limit_cycles .*", ""),
    (r"; modes of one frequency share a tone, .*", ""),
    (r"\bgive sample_rate= \[Hz\]", "give --sample-rate [Hz]"),
    (r"\bgive unit=, such as", "give --unit, such as"),
    (r"\bgive unit=$", "give --unit"),
    (r"\bgive force_unit=$", "give --force-unit"),
    (r"\bby channels=", "by --channels"),
    (
        r"MistunedDisk\.response without local includes the resonance",
        "Compare with slipmode validate",
    ),
    (r"identify with law='power'", "identify with --law power"),
    (r"\bgive its file: mass=", "give its file: --mass (in scenes mass)"),
    (r'names=\{"(\w+)": (".*?")\}', r"--\1-name \2 (in scenes \1_name)"),
    (r"^files: ", ""),
    (r"^bands\b", "band"),
    (r"such as \[\(100, 140\), \(225, 260\)\]", "such as --band 100 140 --band 225 260"),
)


def command_words(message: str, options: Container[str] = ()) -> str:
    """Return a message that names command-line options and scene keys, not Python arguments.

    The message may begin with the name of an argument, followed by a colon or by " = " and its
    value; `options` are the names of the options of the command.
    """
    for advice, instead in _ADVICE:
        message = re.sub(advice, instead, message)
    valued = re.match(r"(\w+) = (?=.*:)", message)
    if valued and valued[1] in options:
        return f"--{valued[1].replace('_', '-')} {message[valued.end() :]}"
    name, colon, rest = message.partition(":")
    if not colon:
        return message
    if name in options:
        name = f"--{name.replace('_', '-')}"
    elif name == "frequency" and "span" in options:  # keys of a scene have longer names
        name = "--span"
    elif name == "amplitude":
        name = "model.amplitude"
    return f"{name}:{rest}"
