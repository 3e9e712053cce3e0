"""From the first to the last communication point of a scene, with its recording.

loop.py        the loop of all passes: steps, rows of points, windows of fast motion. Start here
slow.py        one or two modes in slow time, with stretches at full order
waves.py       travelling waves of a bladed disk
integrated.py  a scene at full order
tones.py       several modes on one or two tones
blades.py      mistuned disks
"""
