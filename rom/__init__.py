"""From a structure's matrices to a step-able reduced-order model.

structure = rom.two_mass(beta=0.01)
reduced = rom.reduce(structure, modes=(0, 1))
model = rom.tabulate(reduced, rom.Tanh(limit=2.0, alpha=0.02), amplitude=(4.0, 4.0))
a_A, a_B = rom.steady(model, frequency=(0.98, 1.65), force=({0: 0.15}, {1: 0.25}))

The rooms follow that chain, and the source paper's equations: structure/ (1)-(3), laws/ (28),
reduction/ (8), (13), contact/ (13), (14), (20), table/ (20), slow/ (12), (18), (19), (22)-(25);
identification/ finds laws of the slow flow in measurements, full/ is Eq. (1) integrated in
full, kernel/ what of all that is computed in C. validity/ is what the method assumes.
"""

import logging
from importlib.metadata import version

from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.static_preload import Preload, preload
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.aerodynamics import influence_coefficients
from slipmode.rom.cyclic.diagrams import (
    CampbellDiagram,
    Crossing,
    NodalDiameterDiagram,
    nodal_diameter_diagram,
)
from slipmode.rom.cyclic.lumped_disk import lumped_disk
from slipmode.rom.cyclic.mistuned.amplification import Amplification
from slipmode.rom.cyclic.mistuned.disk_response import DiskResponse
from slipmode.rom.cyclic.mistuned.mistuned_disk import MistunedDisk
from slipmode.rom.cyclic.mistuned.patterns import random_mistuning, stiffness_deviation
from slipmode.rom.cyclic.sector_mesh import SectorMesh
from slipmode.rom.cyclic.structure import CyclicStructure, excited_diameter
from slipmode.rom.cyclic.wave.stability.flutter_growth import FlutterGrowth, flutter_growth
from slipmode.rom.cyclic.wave.stability.pair_stability import CriticalPair
from slipmode.rom.cyclic.wave.travelling_wave import TravellingWave, travelling_wave
from slipmode.rom.cyclic.wave.wave_state import WaveState
from slipmode.rom.cyclic.wave.wave_table import tabulate_waves
from slipmode.rom.errors import SlipmodeError, ValidityWarning
from slipmode.rom.identification.contacts.fit import ContactFit, fit_contacts
from slipmode.rom.identification.first_look import LocalRates
from slipmode.rom.identification.identification import Identification, identify
from slipmode.rom.identification.models.identified import IdentifiedBackbone, IdentifiedLaw
from slipmode.rom.identification.prediction import Prediction
from slipmode.rom.identification.records.measurement import Measurement, Record, RecordReport
from slipmode.rom.identification.records.reading import read_measurement
from slipmode.rom.identification.sine.identification import SineIdentification, identify_sine
from slipmode.rom.identification.sine.levels import SineLevel
from slipmode.rom.identification.sine.prediction import SinePrediction
from slipmode.rom.identification.sine.reading import read_sine_tests
from slipmode.rom.identification.sine.responses import SineTest, SineTests
from slipmode.rom.identification.sine.signals import demodulate_sine_test
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.laws.contacts import Contacts
from slipmode.rom.laws.friction import Coulomb, Friction, Tanh
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.joint_laws import Iwan, Jenkins, Sliders
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.modes import ModeTable, modes
from slipmode.rom.reduction.combination import CombinationResonance, combination_resonances
from slipmode.rom.reduction.interaction.mode_proposals import ModeProposal
from slipmode.rom.reduction.reduction import Reduced, reduce
from slipmode.rom.slow.branches.backbone import Backbone, backbone
from slipmode.rom.slow.branches.performance import PerformanceCurve, performance_curve
from slipmode.rom.slow.branches.response_curve import ResponseCurve, SpecialPoint, response_curve
from slipmode.rom.slow.direct.steady_state import SteadyState, steady_state
from slipmode.rom.slow.limit_cycle import LimitCycle, limit_cycles
from slipmode.rom.slow.motion import Motion, reconstruct, sum_harmonics
from slipmode.rom.slow.rates.decay_rates import decay_rates
from slipmode.rom.slow.rates.model_of_rates import model_of_rates
from slipmode.rom.slow.steady import (
    ResonanceCurve,
    ResonanceSurface,
    resonance,
    resonance_curve,
    steady,
)
from slipmode.rom.slow.tone.tone_curve import ToneCurve, tone_curve
from slipmode.rom.slow.tone.tone_flow import ToneFlow
from slipmode.rom.slow.tone.tone_states import tone_flow
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.slow.units import Units
from slipmode.rom.structure.damping import Rayleigh
from slipmode.rom.structure.labels import Labels
from slipmode.rom.structure.pairing.contact_pairs import contact_pairs
from slipmode.rom.structure.pairing.motion_patches import MotionPatches, motion_patches
from slipmode.rom.structure.pairing.pairs import ContactPairs
from slipmode.rom.structure.structure import Structure, load_structure, two_mass
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.table.model import Model
from slipmode.rom.table.tabulation import tabulate

__all__ = [
    "Accuracy",
    "Amplification",
    "Backbone",
    "CampbellDiagram",
    "CombinationResonance",
    "ContactFit",
    "ContactPairs",
    "ContactProblem",
    "Contacts",
    "Coulomb",
    "CriticalPair",
    "Crossing",
    "CyclicStructure",
    "Discretisation",
    "DiskFlow",
    "DiskResponse",
    "FlutterGrowth",
    "Friction",
    "FrictionalContact",
    "Identification",
    "IdentifiedBackbone",
    "IdentifiedLaw",
    "Iwan",
    "Jenkins",
    "Labels",
    "LimitCycle",
    "LocalRates",
    "Measurement",
    "MistunedDisk",
    "ModeProposal",
    "ModeTable",
    "Model",
    "Motion",
    "MotionPatches",
    "NoContacts",
    "NodalDiameterDiagram",
    "PerformanceCurve",
    "Prediction",
    "Preload",
    "Rayleigh",
    "Record",
    "RecordReport",
    "Reduced",
    "ResonanceCurve",
    "ResonanceSurface",
    "ResponseCurve",
    "SectorMesh",
    "SineIdentification",
    "SineLevel",
    "SinePrediction",
    "SineTest",
    "SineTests",
    "Sliders",
    "SlipmodeError",
    "SlowLaw",
    "SlowTrajectory",
    "SpecialPoint",
    "SteadyState",
    "Structure",
    "Tanh",
    "ToneCurve",
    "ToneFlow",
    "ToneModel",
    "TravellingWave",
    "Units",
    "ValidityWarning",
    "WaveState",
    "__version__",
    "backbone",
    "combination_resonances",
    "contact_pairs",
    "decay_rates",
    "demodulate_sine_test",
    "excited_diameter",
    "fit_contacts",
    "flutter_growth",
    "identify",
    "identify_sine",
    "influence_coefficients",
    "limit_cycles",
    "load_structure",
    "lumped_disk",
    "model_of_rates",
    "modes",
    "motion_patches",
    "nodal_diameter_diagram",
    "performance_curve",
    "preload",
    "random_mistuning",
    "read_measurement",
    "read_sine_tests",
    "reconstruct",
    "reduce",
    "resonance",
    "resonance_curve",
    "response_curve",
    "steady",
    "steady_state",
    "stiffness_deviation",
    "sum_harmonics",
    "tabulate",
    "tabulate_waves",
    "tone_curve",
    "tone_flow",
    "travelling_wave",
    "two_mass",
]

__version__ = version("slipmode")

DiskFlow = ToneFlow  # of a mistuned disk

# Remarks on results go to this logger; the user chooses whether they are shown.
logging.getLogger("slipmode").addHandler(logging.NullHandler())
