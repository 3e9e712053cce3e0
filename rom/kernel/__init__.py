"""The C kernel as Python sees it: functions, structures and status codes of slipmode.h.

slipmode.h is its public interface, with the headers that it includes: start there. The C is in
the rooms of rom/:

contact/   a time step of Eq. (12), stepper.h; friction as resolvents, friction.h, Eq. (28);
           stage/: its stages by TR-BDF2, and their Newton solver; elastic/: elastic contact laws
           and their solver
torus/     Eqs. (13), (14) by characteristics: periodic/search.c, for all laws; march.h: what a
           contact law provides, by rigid/ in lanes and by elastic/; growth.c: the rate correction
table/     look-up of the bicubic surface of S_j, Eq. (20)
slow/      Eqs. (18), (19): slow_flow.c, with coefficients.c and friction_model.c; dopri5.c: time
           steps; entries.c: checked entries; branches/: curves of steady states; component/:
           the step-able component; motion/: Eq. (12) along a trajectory; tone/: amplitudes of
           many modes, or of a mistuned disk, under one force
full/      Eq. (1) in full: esdirk4.h is a step, elastic_step.c that of elastic contacts, full.c
           the time integration
base/      complex numbers and phasors, dense equations, Hermite cubics, lanes, checks, messages

Here structures.py reads the header and checks arrays; library.py loads the functions; handle.py
holds objects of the core that have a state.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.kernel.library import load
from slipmode.rom.kernel.structures import *  # noqa: F403
from slipmode.rom.kernel.structures import INPUTS

OK = 0
BAD_ARGUMENT = 1
NOT_CONVERGED = 4
OUTSIDE_TABLE = 5


lib = load()


def message(status: int) -> str:
    """Return what a status means, in words."""
    return str(lib.sm_message(status).decode())


def check(status: int, doing: str) -> None:
    """Raise SlipmodeError unless the status is OK."""
    if status != OK:
        raise SlipmodeError(f"{doing}: {message(status)}")


def inputs(count: int) -> NDArray[np.void]:
    """Return `count` sm_inputs: no force, frequencies of 1 rad/s, friction limits as tabulated."""
    made = np.zeros(count, dtype=INPUTS)
    made["frequency"] = 1.0
    made["limit_scale"] = 1.0
    return made


def contiguous(values: Any) -> Floats:
    """Return a C-contiguous float64 array that the core can read."""
    return np.ascontiguousarray(values, dtype=float)
