"""A study of a scene with a saved model."""

import numpy as np
from rates.saved_models import RANGE, TWO_SHAPES, steady_sizes, two_modes, two_rates

from slipmode import rom
from slipmode.runner import run_study
from slipmode.runner.study.study_file import load_study

FREQUENCY = 2.0 * np.pi * np.array([121.6, 242.6])
SCENE = f"""
[model]
file = "two.npz"
[forcing.A]
dof = 0
amplitude = 4.0
frequency = {FREQUENCY[0]}
[forcing.B]
dof = 1
amplitude = 5.0
frequency = {FREQUENCY[1]}
[run]
duration = 9.0
step = 0.01
"""
STUDY = """
[[vary]]
key = "forcing.A.amplitude"
values = [2.0, 4.0, 400.0]
[outputs]
steady = true
times = [9.0]
dofs = [2]
"""


def test_samples_are_steady_as_written_out(study_file, tmp_path, scheduler):
    two_modes().save(tmp_path / "two.npz")
    path = study_file(STUDY, SCENE)
    data = run_study(path, tmp_path, scheduler=scheduler).dataset().load()
    assert data["status"].values.tolist() == [1, 1, 2]
    assert "outside the friction table" in data["reason"].values[2]
    for k, force in enumerate((2.0, 4.0)):
        modal = [force * TWO_SHAPES[0, 0], 5.0 * abs(TWO_SHAPES[1, 1])]
        exact = steady_sizes(two_rates, modal, FREQUENCY)
        np.testing.assert_allclose(data["steady"][k], exact, rtol=1e-4)
        np.testing.assert_allclose(data["at"][k, :, 0], exact, rtol=1e-3)
        found = exact * np.exp(1j * data["steady_phase"][k].values)
        moved = 2.0 * np.abs(TWO_SHAPES[2] * found + other_mode([force, 5.0]))
        np.testing.assert_allclose(data["steady_displacement"][k, :, 0], moved, rtol=1e-4)


def other_mode(force):
    """Displacement of DOF 2 at each carrier by the mode that is off resonance."""
    (damping,), (omega,) = two_rates(np.zeros((1, 2)))
    shapes, Omega = TWO_SHAPES[:, ::-1], FREQUENCY  # of the other mode, for each force
    natural = omega[::-1] ** 2 + damping[::-1] ** 2
    D = natural - Omega**2 + 2j * damping[::-1] * Omega
    return shapes[2] * 0.5 * np.array(force) * np.diag(shapes) / D


def test_results_depend_on_the_file(study_file, tmp_path):
    two_modes().save(tmp_path / "two.npz")
    path = study_file(STUDY, SCENE)
    before = load_study(path).digest
    assert load_study(path).digest == before
    coarse = rom.model_of_rates(two_rates, (RANGE, RANGE), 1e-2, mode_shapes=TWO_SHAPES)
    coarse.save(tmp_path / "two.npz")
    assert load_study(path).digest != before
    assert load_study(path).scene.model.tolerance == 1e-2
