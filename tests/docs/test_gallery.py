"""The examples of the gallery run, are short, and keep their numbers."""

import runpy
from pathlib import Path

import matplotlib
import numpy as np
import pytest

GALLERY = Path(__file__).parents[2] / "examples" / "gallery"
NUMBERS = {  # name, what it computes, to three digits
    "backbone": lambda n: (n["most"], [0.00876]),
    "blade_flutter": lambda n: (
        [n["linear"].growth.max(), *n["amplitude"][:16:15], n["amplitude"][-1]],
        [0.9363, 0.03617, 0.01254, 0.0],
    ),
    "damper_design": lambda n: ([n["best"], n["least"]], [1.531, 3.020]),
    "flutter": lambda n: (n["amplitude"][[0, -1]], [1.044, 2.200]),
    "full_order": lambda n: (1.0 + n["error"], [1.00026]),
    "hysteresis": lambda n: (n["power"], [0.2715]),
    "lift_off": lambda n: (n["fall"], [0.1427]),
    "mistuning": lambda n: (list(n["median"].values()), [1.497, 1.275]),
    "response_curve": lambda n: (list(n["peaks"].values()), [57.25, 34.91, 29.58, 29.94, 34.97]),
    "sweep": lambda n: ([max(n["swept"]), n["lag"]], [2.841, 9.467]),
    "two_modes": lambda n: (n["damping"][[0, 20, 39], 0], [0.01006, 0.01193, 0.01516]),
}


def test_all_of_them_are_held():
    assert {path.stem.removeprefix("plot_") for path in GALLERY.glob("*.py")} == NUMBERS.keys()
    assert len(NUMBERS) >= 10


SLOW = ("backbone", "blade_flutter", "lift_off", "mistuning", "response_curve")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in NUMBERS]
)
def test_an_example_is_short_and_keeps_its_numbers(name):
    path = GALLERY / f"plot_{name}.py"
    assert len(path.read_text(encoding="utf-8").splitlines()) < 40
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.close("all")
    found, expected = NUMBERS[name](runpy.run_path(str(path)))
    np.testing.assert_allclose(found, expected, rtol=2e-3)
    (figure,) = map(plt.figure, plt.get_fignums())
    assert all(axes.has_data() and axes.get_ylabel() for axes in figure.axes)
    plt.close("all")
