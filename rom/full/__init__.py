"""Full-order time integration: the reference that the reduced model is measured against.

drive = full.Excitation.harmonic(structure, force=({0: 0.15}, {1: 0.25}), frequency=(0.98, 1.65))
motion = full.integrate(structure, law, drive, times=600.0)
reference = full.converged(structure, law, drive, times=600.0)
steady = full.steady_amplitude(structure, law, drive, outputs=(0, 1))
"""

from slipmode.rom.full.convergence import Converged, converged
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import integrate
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.steady import SteadyAmplitude, steady_amplitude

__all__ = [
    "Converged",
    "Excitation",
    "FullMotion",
    "State",
    "SteadyAmplitude",
    "converged",
    "integrate",
    "steady_amplitude",
]
