"""From a structure's matrices to a step-able reduced-order model.

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0, 1))
model = rom.tabulate(reduced, rom.Tanh(limit=2.0, alpha=0.02), amplitude=(4.0, 4.0))
a_A, a_B = rom.steady(model, frequency=(0.98, 1.65), force=({0: 0.15}, {1: 0.25}))
"""

from rom.errors import SlipmodeError
from rom.friction import Coulomb, Friction, Tanh
from rom.model import Model
from rom.motion import Motion, reconstruct, sum_harmonics
from rom.near import NearResonance, near_resonances
from rom.quality import Quality
from rom.reduction import Reduced, reduce
from rom.resonance import ResonanceCurve, ResonanceSurface, resonance, resonance_curve, steady
from rom.slow_trajectory import SlowTrajectory
from rom.structure import Structure, load_structure, two_mass
from rom.tabulation import tabulate
from rom.visited import Visited

__all__ = [
    "Coulomb",
    "Friction",
    "Model",
    "Motion",
    "NearResonance",
    "Quality",
    "Reduced",
    "ResonanceCurve",
    "ResonanceSurface",
    "SlipmodeError",
    "SlowTrajectory",
    "Structure",
    "Tanh",
    "Visited",
    "load_structure",
    "near_resonances",
    "reconstruct",
    "reduce",
    "resonance",
    "resonance_curve",
    "steady",
    "sum_harmonics",
    "tabulate",
    "two_mass",
]
