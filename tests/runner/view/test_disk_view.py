"""All sectors of a bladed disk: as they are recorded."""

import numpy as np
import pytest

from slipmode.runner import load

SECTORS = 24


@pytest.mark.oracle
def test_sectors_of_a_wave_move_one_after_the_other(shipped_scene):
    """Nodal diameter 3: sector j is ahead of sector 0 by j eighths of a period."""
    disk = load(shipped_scene("bladed-disk").mcap)["/disk"]
    first = disk.column("x_0")
    turned = first + 1j * disk.column("x_2")  # a quarter of a period ahead
    size = np.abs(first).max()
    for j in range(SECTORS):
        ahead = np.real(turned * np.exp(-2j * np.pi * 3 * j / SECTORS))
        # the amplitude changes by 2 % in the window
        assert np.abs(disk.column(f"x_{j}") - ahead).max() < 0.02 * size
    states = np.stack([disk.column(f"state_{j}") for j in range(SECTORS)])
    assert {0.0, 1.0} == set(states.ravel())
    np.testing.assert_array_equal(states[:8], states[8:16])
