"""Motion of a contact over the phases of both carriers, as it is recorded."""

import numpy as np
import pytest
from runs import replaced
from scipy.interpolate import griddata

from slipmode.runner import load, load_scene, parse_scene, run

TURN = 2 * np.pi
COARSE = load_scene("two-mode").text.replace("tolerance = 1e-3", "tolerance = 1e-2")


def on_surface(recorded, field):
    """Values of a field of /torus at the phases of the contact window, by linear interpolation."""
    torus = recorded["/torus"]
    phases = torus.values[:, :2] % TURN
    shifts = np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1)]) * TURN
    periodic = (phases[:, np.newaxis] + shifts).reshape(-1, 2)
    values = np.repeat(torus.column(field), len(shifts))
    return griddata(periodic, values, recorded["/phases"].values % TURN)


def distance(found, expected):
    return np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2))


@pytest.mark.parametrize(
    ("changes", "bounds"),
    [
        ([], (0.01, 0.02)),  # linear interpolation between 32 phases of B
        pytest.param(
            [('law = "tanh"', 'law = "coulomb"'), ("alpha", "# alpha"), ("[run]", "LIMITS[run]")],
            (0.01, 0.03),  # Coulomb friction has corners; 14 % without the scale of the limits
            marks=pytest.mark.slow,
        ),
        ([("A = 0\nB = 1", "A = 1\nB = 0"), ("[forcing.A]", "[forcing.C]"),
          ("[forcing.B]", "[forcing.A]"), ("[forcing.C]", "[forcing.B]")], (0.02, 0.05)),
    ],
    ids=["two-mode", "scaled limits", "A is faster"],
)  # fmt: skip
def test_the_recorded_motion_lies_on_the_recorded_surface(tmp_path, changes, bounds):
    text = replaced(COARSE, *changes)
    text = text.replace("LIMITS", "[limits]\nscale = [[0, 1.0], [300, 0.6]]\n")
    recorded = load(run(parse_scene(text, tmp_path), tmp_path).mcap)
    for field, bound in zip("xf", bounds, strict=True):
        assert distance(on_surface(recorded, field), recorded["/contact/0"].column(field)) < bound


@pytest.mark.slow
@pytest.mark.oracle
def test_phases_are_the_integrals_of_the_swept_frequencies(tmp_path):
    text = load_scene("sweep").text.replace("6000.0", "60.0").replace("6000,", "60,")
    text = text.replace("[3150.0, 3200.0]", "[30.0, 50.0]")
    text += "\n[model]\ntolerance = 1e-2\n"
    recorded = load(run(parse_scene(text, tmp_path), tmp_path).mcap)["/phases"]
    time = recorded.time
    for mode, first, last in (("A", 0.94, 1.02), ("B", 1.74, 1.58)):
        angle = first * time + 0.5 * (last - first) / 60.0 * time**2
        apart = recorded.column(f"{mode}_phase") - angle
        assert np.abs((apart + np.pi) % TURN - np.pi).max() < 1e-9
