"""Scenes through slow time: plan, run, record, replay."""

from runner.load import Signals, load, read
from runner.plan import Plan, make_plan
from runner.replay import replay
from runner.run import Recording, run
from runner.scene import Scene, load_scene, shipped_scenes

__all__ = [
    "Plan",
    "Recording",
    "Scene",
    "Signals",
    "load",
    "load_scene",
    "make_plan",
    "read",
    "replay",
    "run",
    "shipped_scenes",
]
