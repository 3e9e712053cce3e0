"""Scenes through slow time: plan, run, record, replay."""

from slipmode.rom import __version__
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.recording.load import Signals, load, read
from slipmode.runner.run import Recording, run
from slipmode.runner.scene.scene import Scene, load_scene, shipped_scenes
from slipmode.runner.view.replay import replay

__all__ = [
    "Plan",
    "Recording",
    "Scene",
    "Signals",
    "__version__",
    "load",
    "load_scene",
    "make_plan",
    "read",
    "replay",
    "run",
    "shipped_scenes",
]
