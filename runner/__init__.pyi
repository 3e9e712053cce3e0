"""Public names of slipmode.runner, each imported from its module when it is first used."""

from .curves.scene_curves import (
    scene_backbone,
    scene_performance,
    scene_response_curve,
)
from .explore.explore import explore
from .fmi.export import export_fmu
from .plan.mistuned import MistunedPlan, plan_scene
from .plan.plan import Plan, make_plan
from .plan.shared_tone import SharedTonePlan
from .recording.check import Info, doctor, info
from .recording.load import DamagedRecordingWarning, Signals, load, read
from .recording.recover import Recovery, recover
from .run import Recording, run
from .scene.scene import Scene, load_scene, parse_scene, shipped_scenes
from .study.results import open_results
from .study.study import StudyResults, run_study
from .validation.validate import Validation, validate
from .view.mesh.motion import MeshMotion, show_mesh, write_mesh
from .view.replay import replay

__version__: str

__all__ = [
    "DamagedRecordingWarning",
    "Info",
    "MeshMotion",
    "MistunedPlan",
    "Plan",
    "Recording",
    "Recovery",
    "Scene",
    "SharedTonePlan",
    "Signals",
    "StudyResults",
    "Validation",
    "__version__",
    "doctor",
    "explore",
    "export_fmu",
    "info",
    "load",
    "load_scene",
    "make_plan",
    "open_results",
    "parse_scene",
    "plan_scene",
    "read",
    "recover",
    "replay",
    "run",
    "run_study",
    "scene_backbone",
    "scene_performance",
    "scene_response_curve",
    "shipped_scenes",
    "show_mesh",
    "validate",
    "write_mesh",
]
