"""Names of slipmode.rom.contact for other rooms, each imported when it is first used."""

from .harmonics import Harmonics as Harmonics
from .problem import TorusProblem as TorusProblem
from .slip_onset import slip_onset as slip_onset
from .terms import ContactTerms as ContactTerms
from .torus.march import ContactForces as ContactForces
