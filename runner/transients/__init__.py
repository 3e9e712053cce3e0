"""Transients: the error that slow time has in them, and stretches of a scene at full order.

estimate.py estimates the error, hybrid.py switches to full order and back, full_order.py
integrates a stretch, demodulation.py takes amplitudes out of it; reference.py is a whole scene.
"""
