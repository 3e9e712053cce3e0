"""A scene by Co-Simulation, by Model Exchange and by `slipmode run`: the same."""

import numpy as np
import pytest
from fmu_exchange import SceneFmu

from slipmode import runner
from slipmode.runner import export_fmu, load_scene, shipped_scenes

WITHIN = 1e-4
SHIPPED = [
    pytest.param(name, marks=[] if name in ("one-mode", "two-mode") else [pytest.mark.slow])
    for name in shipped_scenes()
    if not load_scene(name).mistuning
]


def recorded(recording):
    """Time, amplitudes and dissipated energy of a recording."""
    channels = recording.read().channels
    _, time, modes = channels["/modes"]
    amplitudes = 2 * len(recording.plan.excited.modes)
    return time, np.column_stack((modes[:, :amplitudes], channels["/energy"][2][:, 2]))


def apart(found, expected):
    """Largest difference of each column, relative to its largest value."""
    return np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)


@pytest.mark.parametrize("name", SHIPPED)
def test_three_ways_agree(name, tmp_path):
    scene = load_scene(name)
    path = export_fmu(scene, tmp_path / f"{name}.fmu", headroom=1.0)
    driven = SceneFmu(path, scene)
    time, expected = recorded(runner.run(scene, tmp_path / "through", fmu=path))
    assert np.abs(expected).max(axis=0).min() > 0.0
    for way in (
        driven.co_simulated(),
        driven.exchanged(driven.adaptive),
        driven.exchanged(driven.fixed),
    ):
        np.testing.assert_allclose(way[0], time, rtol=1e-9)
        assert apart(way[1], expected).max() < WITHIN
    _, plain = recorded(runner.run(scene, tmp_path / "plain"))
    assert apart(plain, expected).max() < WITHIN
