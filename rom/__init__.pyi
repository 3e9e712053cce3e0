"""Public names of slipmode.rom, each imported from its module when it is first used."""

from .contact.problem import ContactProblem
from .contact.static_preload import Preload, preload
from .contact.torus.grid import Discretisation
from .cyclic.aerodynamics import influence_coefficients
from .cyclic.diagrams import (
    CampbellDiagram,
    Crossing,
    NodalDiameterDiagram,
    nodal_diameter_diagram,
)
from .cyclic.lumped_disk import lumped_disk
from .cyclic.mistuned.amplification import Amplification
from .cyclic.mistuned.disk_response import DiskResponse
from .cyclic.mistuned.mistuned_disk import DiskFlow, MistunedDisk
from .cyclic.mistuned.patterns import random_mistuning, stiffness_deviation
from .cyclic.sector_mesh import SectorMesh
from .cyclic.structure import CyclicStructure, excited_diameter
from .cyclic.wave.stability.flutter_growth import FlutterGrowth, flutter_growth
from .cyclic.wave.stability.pair_stability import CriticalPair
from .cyclic.wave.travelling_wave import TravellingWave, travelling_wave
from .cyclic.wave.wave_state import WaveState
from .cyclic.wave.wave_table import tabulate_waves
from .errors import SlipmodeError, ValidityWarning
from .identification.contacts.fit import ContactFit, fit_contacts
from .identification.first_look import LocalRates
from .identification.identification import Identification, identify
from .identification.models.identified import IdentifiedBackbone, IdentifiedLaw
from .identification.prediction import Prediction
from .identification.records.measurement import Measurement, Record, RecordReport
from .identification.records.reading import read_measurement
from .identification.sine.identification import SineIdentification, identify_sine
from .identification.sine.levels import SineLevel
from .identification.sine.prediction import SinePrediction
from .identification.sine.reading import read_sine_tests
from .identification.sine.responses import SineTest, SineTests
from .identification.sine.signals import demodulate_sine_test
from .identification.slow_laws import SlowLaw
from .laws.contacts import Contacts
from .laws.friction import Coulomb, Friction, Tanh
from .laws.frictional_contact import FrictionalContact
from .laws.joint_laws import Iwan, Jenkins, Sliders
from .laws.no_contacts import NoContacts
from .modes import ModeTable, modes
from .reduction.combination import CombinationResonance, combination_resonances
from .reduction.interaction.mode_proposals import ModeProposal
from .reduction.reduction import Reduced, reduce
from .slow.branches.backbone import Backbone, backbone
from .slow.branches.performance import PerformanceCurve, performance_curve
from .slow.branches.response_curve import ResponseCurve, SpecialPoint, response_curve
from .slow.direct.steady_state import SteadyState, steady_state
from .slow.limit_cycle import LimitCycle, limit_cycles
from .slow.motion import Motion, reconstruct, sum_harmonics
from .slow.rates.decay_rates import decay_rates
from .slow.rates.model_of_rates import model_of_rates
from .slow.steady import (
    ResonanceCurve,
    ResonanceSurface,
    resonance,
    resonance_curve,
    steady,
)
from .slow.tone.tone_curve import ToneCurve, tone_curve
from .slow.tone.tone_flow import ToneFlow
from .slow.tone.tone_states import tone_flow
from .slow.trajectory import SlowTrajectory
from .slow.units import Units
from .structure.damping import Rayleigh
from .structure.labels import Labels
from .structure.pairing.contact_pairs import contact_pairs
from .structure.pairing.motion_patches import MotionPatches, motion_patches
from .structure.pairing.pairs import ContactPairs
from .structure.structure import Structure, load_structure, two_mass
from .table.accuracy import Accuracy
from .table.local.tone_model import ToneModel
from .table.model import Model
from .table.tabulation import tabulate

__version__: str

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
