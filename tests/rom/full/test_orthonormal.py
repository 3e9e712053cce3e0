"""Modes and other shapes combined into a basis that is orthonormal in the mass."""

import numpy as np
import pytest

from slipmode.rom.full.structures import orthonormal

N, MODES = 12, 3


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_shapes_that_depend_on_others_are_left_out(scale):
    """Three are new; one is in the modes, one in the other shapes, one is nothing."""
    rng = np.random.default_rng(3)
    M = np.diag(rng.uniform(0.5, 2.0, N))
    modes = np.linalg.qr(rng.standard_normal((N, N)))[0][:, :MODES] / np.sqrt(np.diag(M))[:, None]
    new = rng.standard_normal((N, 3)) * [1.0, 1e4, 1e-4]
    inside = modes @ rng.standard_normal(MODES)
    shapes = scale * np.column_stack((new, inside, new @ [1.0, 1e-4, 1e4], np.zeros(N)))
    T = orthonormal(modes.T @ M @ shapes, shapes.T @ M @ shapes)
    assert T.shape == (MODES + 6, MODES + 3)
    basis = np.hstack((modes, shapes)) @ T
    np.testing.assert_array_equal(basis[:, :MODES], modes)
    np.testing.assert_allclose(basis.T @ M @ basis, np.eye(MODES + 3), atol=1e-9)
    inside_basis = basis @ np.linalg.lstsq(basis, shapes, rcond=None)[0]
    np.testing.assert_allclose(inside_basis, shapes, atol=1e-9 * np.abs(shapes).max())
