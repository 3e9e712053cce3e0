"""Scenes through slow time: plan, run, record, replay."""

from runner.plan import Plan, make_plan
from runner.replay import read, replay
from runner.run import Recording, run
from runner.scene import Scene, load_scene, shipped_scenes

__all__ = [
    "Plan",
    "Recording",
    "Scene",
    "load_scene",
    "make_plan",
    "read",
    "replay",
    "run",
    "shipped_scenes",
]
