"""A scene from its start to its end, in slow time or at full order.

passes.py         a pass through a scene, with its recording. Start here
tone_pass.py      a pass of several modes on one or two tones; mistuned_pass.py: of mistuned disks
motion.py         the slow trajectory, fast motion, and what is recorded of them
estimate.py       the estimated error of slow time in transients
friction_error.py the error of a run by friction beyond the tolerance
hybrid.py         slow time, and full order where the error is too large
full_order.py     a stretch at full order; demodulation.py: its amplitudes
"""
