"""Scenes through slow time: plan, run, record, replay.

recording = runner.run("two-mode")  # or the path of a scene
runner.replay(recording.mcap)

run.py          what run does, from the scene to the recording. Start here; slow_pass.py: its steps
scene/ plan/ motion/ recording/ view/   in the order in which it needs them; scenes/: shipped
curves/ study/  what a scene does at other frequencies, forces, limits; and at any other values
validate.py     a scene by slow time and by full order; report/, paper/: the method, measured so
fmi/            a scene as an FMU
cli.py          the command line; recording_commands.py: info, doctor, recover, export, replay
"""

from slipmode.rom import __version__
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.recording.load import Signals, load, read
from slipmode.runner.run import Recording, run
from slipmode.runner.scene.scene import Scene, load_scene, shipped_scenes
from slipmode.runner.study.study import StudyResults, run_study
from slipmode.runner.view.mesh.motion import MeshMotion, write_mesh
from slipmode.runner.view.mesh.show import show_mesh
from slipmode.runner.view.replay import replay

__all__ = [
    "MeshMotion",
    "Plan",
    "Recording",
    "Scene",
    "Signals",
    "StudyResults",
    "__version__",
    "load",
    "load_scene",
    "make_plan",
    "read",
    "replay",
    "run",
    "run_study",
    "shipped_scenes",
    "show_mesh",
    "write_mesh",
]
