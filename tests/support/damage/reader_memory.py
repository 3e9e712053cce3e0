"""Run the commands for recordings on a file; print the memory that each takes beyond the start."""

import contextlib
import io
import os
import resource
import sys
from pathlib import Path

import numpy as np
import rerun
from commands import COMMANDS  # beside this script

from slipmode.__main__ import main

assert np and rerun  # imported for what they take


def peak():
    """Largest memory of this process so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


sound, *paths = map(Path, sys.argv[1:])
os.chdir(sound.parent)
for command, options in COMMANDS.items():  # what they take anyway
    with contextlib.redirect_stdout(io.StringIO()):
        assert main([command, str(sound), *options]) == 0
before = peak()
for path in paths:
    for command, options in COMMANDS.items():
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            main([command, str(path), *options])
        print(f"{path.stem}: {command}\t{peak() - before:.0f}", flush=True)
