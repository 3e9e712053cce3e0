"""What a scene needs modelled, and why, before anything is computed for it.

plan.py              make_plan: every decision with its reason. Start here.
amplitude_range.py   a dry run on a coarse table: how far the amplitudes go
settling.py          how long held inputs have to be followed in it
fast_motion.py       fast motion marched or summed: what a sum of harmonics leaves out
assumptions.py       the findings of rom/validity/ for a scene; time_scales.py: of its steps
euler_step.py        a step that fixed-step importers of its FMU can take
"""
