"""Transients: the error of slow time in them, and stretches of a scene at full order.

estimate.py       the estimated error
hybrid.py         slow time, and full order where the error is too large
integrated.py     a scene without slow time
full_order.py     a stretch at full order; demodulation.py: its amplitudes
"""
