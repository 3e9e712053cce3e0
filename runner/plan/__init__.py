"""What a scene needs modelled, and why, before anything is computed for it.

plan.py              make_plan: every decision with its reason. Start here.
mistuned.py          plan_scene, for any scene; the plan of a mistuned disk
shared_tone.py       the plan of several modes on a tone; scene_plan.py: what all plans have
excited.py           the modes that move, and the forces on them
amplitude_range.py   a dry run on a coarse table: how far the amplitudes go
transients.py        stretches at full order
checks.py            steps that are too long, windows that are too large, strained assumptions
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
