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

import lazy_loader

from slipmode import __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]
