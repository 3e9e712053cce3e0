"""Transients: how fast amplitudes change, and stretches of a scene at full order.

change.py watches the slow flow, hybrid.py hands over between it and full order, full_order.py
integrates a stretch, demodulation.py takes amplitudes out of it; reference.py is a whole scene.
"""
