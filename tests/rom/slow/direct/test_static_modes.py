"""Modes that follow statically are in the stated error: blades with a very stiff contact."""

import numpy as np
import pytest
import scipy.linalg
from elastic.family import blade

from slipmode import rom


@pytest.mark.parametrize("length", [14, 16, 18, 20])
def test_the_error_contains_the_effect_of_static_modes(length):
    """The contact is 1e4 times stiffer than the blade; all modes are kept for comparison."""
    M, K = (matrix[8:, 8:] for matrix in blade(length, 3))
    n = len(M)
    W = np.zeros((n, 1))
    W[8 * (length - 2) + 3] = 1.0
    lowest = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[0])
    structure = rom.Structure(M, K, 1e-3 / lowest, contact=W)
    law = rom.Jenkins(1.0, 1e4 / (W.T @ np.linalg.solve(K, W)).item())
    force = np.zeros(n)
    force[8 * (length // 2) + 1] = 3.0
    few, all_modes = (
        rom.steady_state(reduced, law, [0.9 * reduced.frequency[0]], [force])
        for reduced in (
            rom.reduce(structure, (0,), law=law, smallest_response=least) for least in (1e-5, 0.0)
        )
    )
    off = np.abs(few.amplitude - all_modes.amplitude)
    assert np.all(off > 0.0)
    assert np.all(off <= few.error)
