"""Scenes through slow time: plan, run, record, replay.

recording = runner.run("two-mode")  # or the path of a scene
runner.replay(recording.mcap)

run.py       run: from the scene to the recording. Start here
scene/ plan/ transients/ recording/ view/   in the order in which run needs them
scenes/      the shipped scenes
validation/  a scene compared with full order
curves/      response curves, backbones, damper design of a scene
study/       a scene with many other values
fmi/         a scene as an FMU
explore/     a scene as an HTML file that computes in a browser
cli.py       the command line; commands/: behind it
"""

from slipmode.rom import __version__
from slipmode.runner.curves.scene_curves import (
    scene_backbone,
    scene_performance,
    scene_response_curve,
)
from slipmode.runner.explore.explore import explore
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.plan.mistuned import MistunedPlan, plan_scene
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.plan.shared_tone import SharedTonePlan
from slipmode.runner.recording.check import Info, doctor, info
from slipmode.runner.recording.load import DamagedRecordingWarning, Signals, load, read
from slipmode.runner.recording.recover import Recovery, recover
from slipmode.runner.run import Recording, run
from slipmode.runner.scene.scene import Scene, load_scene, parse_scene, shipped_scenes
from slipmode.runner.study.results import open_results
from slipmode.runner.study.study import StudyResults, run_study
from slipmode.runner.validation.validate import Validation, validate
from slipmode.runner.view.mesh.motion import MeshMotion, show_mesh, write_mesh
from slipmode.runner.view.replay import replay

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
