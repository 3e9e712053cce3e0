"""Public names of slipmode.runner, each imported from its module when it is first used."""

from .curves.scene_curves import scene_backbone as scene_backbone
from .curves.scene_curves import scene_performance as scene_performance
from .curves.scene_curves import scene_response_curve as scene_response_curve
from .explore.explore import explore as explore
from .fmi.export import export_fmu as export_fmu
from .plan.plan import Plan as Plan
from .plan.planning import make_plan as make_plan
from .plan.planning import plan_scene as plan_scene
from .recording.check import Info as Info
from .recording.check import doctor as doctor
from .recording.check import info as info
from .recording.load import DamagedRecordingWarning as DamagedRecordingWarning
from .recording.load import Signals as Signals
from .recording.load import load as load
from .recording.load import read as read
from .recording.recover import Recovery as Recovery
from .recording.recover import recover as recover
from .run import Recording as Recording
from .run import run as run
from .scene.scene import Scene as Scene
from .scene.scene import load_scene as load_scene
from .scene.scene import parse_scene as parse_scene
from .scene.scene import shipped_scenes as shipped_scenes
from .study.results import open_results as open_results
from .study.study import StudyResults as StudyResults
from .study.study import run_study as run_study
from .validation.validate import Validation as Validation
from .validation.validate import validate as validate
from .view.mesh.motion import MeshMotion as MeshMotion
from .view.mesh.motion import show_mesh as show_mesh
from .view.mesh.motion import write_mesh as write_mesh
from .view.replay import replay as replay

__version__: str
