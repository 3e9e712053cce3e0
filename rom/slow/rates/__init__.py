"""Damping and frequency of free vibration: of any model, and models made from them.

decay_rates.py     of any model, at any amplitudes
model_of_rates.py  the model that has given ones, without contacts
rate_samples.py    its samples: other rates that are as likely
"""
