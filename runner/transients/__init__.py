"""A scene from its start to its end, in slow time or at full order.

passes/           a pass through a scene, with its recording. Start here
motion.py         the slow trajectory, fast motion, and what is recorded of them
errors.py         the estimated errors of slow time, in transients and by friction
energy.py         powers of the energy balance
full_order.py     a stretch at full order; demodulation.py: its amplitudes
"""
