"""Full-order time integration of Eq. (1): the reference for the reduced model.

force = ({0: 0.15}, {1: 0.25})
excitation = full.Excitation.harmonic(structure, force, frequency=(0.98, 1.65))
motion = full.integrate(structure, law, excitation, times=600.0)
reference = full.converged(structure, law, excitation, times=600.0)
steady = full.steady_amplitude(structure, law, excitation, outputs=(0, 1))

integration.py        integrate: the march; its steps are in rom/kernel/full. Start here.
excitation.py         Eq. (2); motion.py: states and motions
coordinates.py        the modes in which a step is solved; time_steps.py: which steps
convergence.py        motions with their own error estimate
steady.py, window.py  carrier amplitudes of steady motions
harmonic_fit.py       all harmonics from a few periods
component_modes.py    Craig-Bampton or stuck modes of large structures
structures.py         projected, reduced and aeroelastic structures
"""

from slipmode.rom.full.component_modes import ComponentModes, component_modes
from slipmode.rom.full.convergence import Converged, converged
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import integrate
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.steady import SteadyAmplitude, steady_amplitude
from slipmode.rom.full.structures import aeroelastic

__all__ = [
    "ComponentModes",
    "Converged",
    "Excitation",
    "FullMotion",
    "State",
    "SteadyAmplitude",
    "aeroelastic",
    "component_modes",
    "converged",
    "integrate",
    "steady_amplitude",
]
