"""Values from 1e-30 to 1e30 are planned."""

import numpy as np
import pytest

from slipmode.runner import make_plan, parse_scene

SCENE = """
structure = {{model = "two-mass", damping = 0.01{structure}}}
friction = {{law = "{law}", limit = 2.0{alpha}}}
modes = {{A = 0, B = 1}}
forcing.A = {{dof = 0, amplitude = 0.15, frequency = 0.98}}
forcing.B = {{dof = 1, amplitude = 0.25, frequency = 1.65}}
run = {{duration = 50.0, step = 1.0}}
"""
TANH = {"law": "tanh", "alpha": ", alpha = 0.02", "structure": ""}
COULOMB = {"law": "coulomb", "alpha": "", "structure": ""}


@pytest.mark.parametrize(
    ("given", "change"),
    [
        (TANH, ("limit = 2.0", "limit = 1e30")),
        (COULOMB, ("limit = 2.0", "limit = 1e-30")),
        (TANH, ("amplitude = 0.25", "amplitude = 1e-30")),
        (TANH, ("amplitude = 0.", "amplitude = 1e30, phase = 0.")),
        (TANH | {"alpha": ", alpha = 1e-30"}, ("", "")),
        (TANH | {"alpha": ", alpha = 1e30"}, ("", "")),
        (TANH, ("damping = 0.01", "damping = 1e-30")),
        (TANH | {"structure": ", k_c1 = 1e15"}, ("", "")),
        (TANH | {"structure": ", contact_mass = 1e-30"}, ("", "")),
    ],
    ids=str,
)
def test_extreme_values_have_a_plan(given, change):
    text = SCENE.format(**given)
    assert change[0] in text
    assert np.isfinite(make_plan(parse_scene(text.replace(*change), ".")).amplitude).all()
