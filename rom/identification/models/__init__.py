"""Models of identified laws.

law_model.py       the law as a model that runs. Start here.
sensor_units.py    sensor units as modal amplitudes
"""
