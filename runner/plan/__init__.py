"""What a scene needs modelled, and why, before anything is computed for it.

planning.py          plan_scene, for any scene. Start here.
plan.py              Plan, what all plans have
modes.py             one or two modes or waves: every decision with its reason
tones.py, blades.py  several modes on a tone; the blades of a mistuned disk
excited.py, waves.py modes or waves that move, and the forces on them
amplitude_range.py   a dry run on a coarse table: how far the amplitudes go
transients.py        stretches at full order
checks.py            steps that are too long, windows that are too large, strained assumptions
"""
