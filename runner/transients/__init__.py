"""Transients: the error of slow time in them, and stretches of a scene at full order.

estimate.py       the estimated error
passes.py         a pass through a scene, in slow time or at full order, with its recording
hybrid.py         slow time, and full order where the error is too large
full_order.py     a stretch at full order; demodulation.py: its amplitudes
"""
