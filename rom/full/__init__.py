"""Full-order time integration of Eq. (1): the reference for the reduced model.

force = ({0: 0.15}, {1: 0.25})
excitation = full.Excitation.harmonic(structure, force, frequency=(0.98, 1.65))
motion = full.integrate(structure, law, excitation, times=600.0)
reference = full.converged(structure, law, excitation, times=600.0)
steady = full.steady_amplitude(structure, law, excitation, outputs=(0, 1))

excitation.py is Eq. (2), integration.py the march (its steps: rom/kernel/full/esdirk4.h, and
rom/kernel/full/elastic_step.h for elastic contacts), bases/ what large structures run on;
convergence.py says how exact it is, steady.py takes carrier amplitudes out of it, by window.py;
harmonic_fit.py takes all harmonics out of a few periods of it;
aeroelastic.py gives a structure the aerodynamic forces that its reduction has.
"""

from slipmode.rom.full.aeroelastic import aeroelastic
from slipmode.rom.full.bases.component_modes import ComponentModes, component_modes
from slipmode.rom.full.convergence import Converged, converged
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import integrate
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.steady import SteadyAmplitude, steady_amplitude

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
